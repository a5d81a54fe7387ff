// The tests' clients talk to a server on a thread of the same process, so that they need no Python.
using System;
using System.Linq;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;
using NUnit.Framework;

namespace NetMQExample.Tests
{
    /// <summary>Answers each request, or publishes, until it is disposed.</summary>
    public sealed class InProcessServer : IDisposable
    {
        private static readonly TimeSpan Timeout = TimeSpan.FromMilliseconds(10);
        private readonly ManualResetEventSlim listening = new ManualResetEventSlim();
        private readonly Thread thread;
        private volatile bool stopped;

        private InProcessServer(Func<NetMQSocket> make, Action<NetMQSocket> step)
        {
            thread = new Thread(() => Serve(make, step)) { IsBackground = true, Name = nameof(InProcessServer) };
            thread.Start();
            Assert.That(listening.Wait(5000), "the server did not begin");
        }

        public string Endpoint { get; private set; }

        /// <summary>A ROUTER, which both REQ and DEALER can ask.</summary>
        /// <param name="answer">Of the frames of a request, without the envelope, makes those of its reply.</param>
        public static InProcessServer Answering(Func<NetMQMessage, NetMQMessage> answer) =>
            new InProcessServer(() => new RouterSocket(), socket =>
            {
                var request = new NetMQMessage();
                if (!socket.TryReceiveMultipartMessage(Timeout, ref request)) return;
                var envelope = new NetMQMessage();
                envelope.Append(request.Pop());
                // A REQ socket puts an empty frame in front of what it asks; lesson 13's asks an empty frame.
                if (request.First.IsEmpty && request.FrameCount > 1) envelope.Append(request.Pop());
                socket.SendMultipartMessage(new NetMQMessage(envelope.Concat(answer(request))));
            });

        /// <summary>A PUB that never ends.</summary>
        /// <param name="text">The text of each message, by a number that counts from 1.</param>
        public static InProcessServer Publishing(Func<int, string> text)
        {
            var number = 0;
            return new InProcessServer(() => new PublisherSocket(), socket =>
            {
                socket.SendFrame(text(++number));
                Thread.Sleep(Timeout);
            });
        }

        public void Dispose()
        {
            stopped = true;
            Assert.That(thread.Join(5000), "the server did not end");
        }

        private void Serve(Func<NetMQSocket> make, Action<NetMQSocket> step)
        {
            using var lifetime = new NetMQLifetime();
            using var socket = make();
            socket.Options.Linger = TimeSpan.Zero;
            Endpoint = $"tcp://127.0.0.1:{socket.BindRandomPort("tcp://127.0.0.1")}";
            listening.Set();
            while (!stopped) step(socket);
        }
    }
}
