// Lesson 03, the smallest subscriber: every message that begins with a prefix, as text.
//
// Take home: this file, NetMQConnection.cs and NetMQLifetime.cs, if no message needs to be missed with notice; else see
// PoseSubscriber.cs. What was sent before the publisher knew of this listener is lost, and nobody says so.
// Bytes: UTF-8 text, one frame, as python/03_publish_subscribe/server.py sends it.
// Trouble: a topic is a prefix. `news` brings newsflash/ as well; the delimiter at its end, `news/`, cures that.
using System;
using System.Diagnostics;
using System.Text;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample
{
    /// <summary>Listens over a SUB socket. Make it, use it and dispose it on one thread.</summary>
    public sealed class TopicListener : IDisposable
    {
        private readonly NetMQConnection connection;
        private readonly string endpoint;
        private bool heard;

        /// <summary>Subscribes and connects, which succeeds even while no publisher is there.</summary>
        /// <param name="endpoint">The publisher, such as <c>tcp://127.0.0.1:5553</c>.</param>
        /// <param name="prefix">How the messages begin; empty for all of them.</param>
        /// <exception cref="ArgumentException">The endpoint cannot work; the message names cause and cure.</exception>
        public TopicListener(string endpoint, string prefix)
        {
            this.endpoint = endpoint;
            connection = new NetMQConnection(endpoint, () =>
            {
                var socket = new SubscriberSocket();
                // Without the encoding, NetMQ makes a question mark of every letter that is not ASCII.
                socket.Subscribe(prefix, Encoding.UTF8);
                return socket;
            });
        }

        /// <summary>Waits for the next message, and so not for Unity's main thread.</summary>
        /// <param name="patience">How long to wait; zero takes only what is there.</param>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        /// <exception cref="TimeoutException">None came.</exception>
        /// <exception cref="OperationCanceledException"><paramref name="stop"/> was cancelled.</exception>
        public string Receive(TimeSpan patience, CancellationToken stop = default)
        {
            var waited = Stopwatch.StartNew();
            var renew = TimeSpan.FromSeconds(2);
            foreach (var slice in NetMQConnection.Slices(patience, stop))
            {
                if (connection.Socket.TryReceiveFrameString(slice, out var text, out var more))
                {
                    // Several frames are one message: its rest must not be taken for the next one.
                    while (more) connection.Socket.SkipFrame(out more);
                    heard = true;
                    return text;
                }
                if (heard || waited.Elapsed < renew) continue;
                // Where the port had been another program's, libzmq connects no more. On a far line it takes its time.
                connection.Close();
                renew *= 3;
            }
            throw new TimeoutException(FormattableString.Invariant(
                $"nothing from {endpoint} within {patience.TotalSeconds} s; is the server running, or the line slow?"));
        }

        /// <summary>Closes the socket, then leaves NetMQ.</summary>
        public void Dispose() => connection.Dispose();
    }
}
