// Lesson 01, request-reply: ask one question, wait for its answer, then ask the next.
//
// The Python side is python/01_request_reply/server.py.
// Bytes: UTF-8 text, one frame each way.
// Trouble: a REQ socket alternates strictly. A second request before the reply is refused with
// "Req.XSend - cannot send another request"; the terminal client shows it with --send-twice.
using System;
using System.Collections.Generic;
using System.Text;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample
{
    /// <summary>Asks a REP server over one REQ socket. Make it, use it and dispose it on one thread, and not on Unity's
    /// main thread: a request blocks until its reply is there.</summary>
    public sealed class HelloRequester : IDisposable
    {
        private readonly NetMQLifetime lifetime = new NetMQLifetime();
        private readonly string endpoint;
        private readonly RequestSocket socket;
        private readonly TimeSpan timeout;
        private bool disposed;

        /// <summary>Connects, which succeeds even while no server is there: ZeroMQ goes on trying.</summary>
        /// <param name="endpoint">The server, such as <c>tcp://127.0.0.1:5551</c>.</param>
        /// <param name="timeout">How long each wait lasts that is not given another; 2.5 s when left out.</param>
        /// <exception cref="ArgumentException">One of them cannot work; the message names cause and cure.</exception>
        public HelloRequester(string endpoint, TimeSpan? timeout = null)
        {
            this.endpoint = endpoint;
            try
            {
                this.timeout = Require.Seconds("timeout", timeout ?? TimeSpan.FromSeconds(2.5));
                socket = new RequestSocket();
                // With linger 0, frames of 64 KB at most, and a check of the endpoint.
                NetMQConnection.Connect(socket, endpoint);
            }
            catch
            {
                Dispose();
                throw;
            }
        }

        /// <summary>Sends a request and waits for its reply.</summary>
        /// <param name="text">The request, sent as UTF-8.</param>
        /// <param name="timeout">How long to wait: until it is sent, and then for the reply.</param>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        /// <exception cref="TimeoutException">No reply came. This requester can only be disposed now.</exception>
        /// <exception cref="OperationCanceledException"><paramref name="stop"/> was cancelled.</exception>
        /// <exception cref="ObjectDisposedException">After Dispose.</exception>
        public string Request(string text, TimeSpan? timeout = null, CancellationToken stop = default)
        {
            Send(text, timeout, stop);
            return Receive(timeout, stop);
        }

        /// <summary>The first half of a request. It waits when there is no connection to send on, as after a peer that
        /// is not ZeroMQ.</summary>
        /// <param name="text">The request, sent as UTF-8.</param>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        /// <exception cref="ArgumentException">The text has more than 65,536 bytes.</exception>
        /// <exception cref="FiniteStateMachineException">The reply to the last request was not received
        /// yet.</exception>
        public void Send(string text, TimeSpan? timeout = null, CancellationToken stop = default)
        {
            var limit = timeout ?? this.timeout;
            Require.Text("text", text);
            // Not the text: NetMQ would make a question mark of every character that is not ASCII.
            var bytes = Encoding.UTF8.GetBytes(text);
            foreach (var slice in NetMQConnection.Slices(limit, stop))
            {
                if (!Socket.TrySendFrame(slice, bytes)) continue;
                NetMQConnection.Show(endpoint, true, new[] { text });
                return;
            }
            throw NetMQConnection.NoReply(endpoint, limit);
        }

        /// <summary>The second half: waits for the reply, as <see cref="Request"/> does.</summary>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        public string Receive(TimeSpan? timeout = null, CancellationToken stop = default)
        {
            var limit = timeout ?? this.timeout;
            // However many frames there are, they are one message.
            List<byte[]> frames = null;
            foreach (var slice in NetMQConnection.Slices(limit, stop))
            {
                if (!Socket.TryReceiveMultipartBytes(slice, ref frames)) continue;
                NetMQConnection.Show(endpoint, false, frames);
                return string.Join(" ", frames.ConvertAll(NetMQConnection.Text));
            }
            throw NetMQConnection.NoReply(endpoint, limit);
        }

        public override string ToString() => $"HelloRequester {endpoint}";

        public void Dispose()
        {
            disposed = true;
            NetMQConnection.Close(socket);
            lifetime.Dispose();
        }

        private RequestSocket Socket => disposed ? throw NetMQConnection.Disposed(endpoint) : socket;
    }
}
