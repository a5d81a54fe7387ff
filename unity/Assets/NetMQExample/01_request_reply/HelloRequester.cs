// Lesson 01, request-reply: ask one question, wait for its answer, then ask the next.
//
// Take home: this file and NetMQLifetime.cs. The Python side is python/01_request_reply/server.py.
// Bytes: UTF-8 text, one frame each way.
// Trouble: a REQ socket alternates strictly. A second request before the reply is refused with
// "Req.XSend - cannot send another request"; the console twin shows it with --send-twice.
using System;
using System.Diagnostics;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample
{
    /// <summary>
    /// Asks a REP server over one REQ socket. Make it, use it and dispose it on one thread, and not on Unity's main
    /// thread: a request blocks until its reply is there.
    /// </summary>
    public sealed class HelloRequester : IDisposable
    {
        // Short enough that Stop in the editor is felt at once, long enough to cost nothing.
        private static readonly TimeSpan Slice = TimeSpan.FromMilliseconds(50);

        private readonly NetMQLifetime lifetime = new NetMQLifetime();
        private readonly RequestSocket socket;
        private readonly string endpoint;

        /// <summary>Connects, which succeeds even while no server is there: ZeroMQ goes on trying.</summary>
        /// <param name="endpoint">The server, such as <c>tcp://127.0.0.1:5551</c>.</param>
        /// <exception cref="ArgumentException">The endpoint cannot work; the message names cause and cure.</exception>
        public HelloRequester(string endpoint)
        {
            this.endpoint = endpoint;
            try
            {
                // In here and not in a field: if NetMQ has no socket to give, NetMQ must be left all the same.
                socket = new RequestSocket();
                // A request that nobody fetched is dropped on Dispose; waiting for its delivery could take for ever.
                socket.Options.Linger = TimeSpan.Zero;
                // A peer that announces more is disconnected before it is in memory.
                socket.Options.MaxMsgSize = 65536;
                NetMQLifetime.Connect(socket, endpoint);
            }
            catch
            {
                Dispose();
                throw;
            }
        }

        /// <summary>How long to look for a reply again and again before sleeping; none when left out. It saves the time
        /// to wake up, some ten microseconds, and keeps a processor core busy meanwhile.</summary>
        public TimeSpan Spin { get; set; }

        /// <summary>Sends a request and waits for its reply.</summary>
        /// <param name="text">The request, sent as UTF-8.</param>
        /// <param name="patience">How long to wait: until it is sent, and then for the reply.</param>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        /// <returns>The reply's text.</returns>
        /// <exception cref="TimeoutException">No reply came. This requester can only be disposed now.</exception>
        /// <exception cref="OperationCanceledException"><paramref name="stop"/> was cancelled.</exception>
        public string Request(string text, TimeSpan patience, CancellationToken stop = default)
        {
            // Here too: while every reply comes in time, Receive never gets to look.
            stop.ThrowIfCancellationRequested();
            Send(text, patience, stop);
            return Receive(patience, stop);
        }

        /// <summary>The first half of a request. It waits when there is no connection to send on, as after a peer that is
        /// not ZeroMQ.</summary>
        /// <param name="text">The request, sent as UTF-8.</param>
        /// <param name="patience">How long to wait for a connection.</param>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        /// <exception cref="FiniteStateMachineException">The reply to the last request was not received yet.</exception>
        public void Send(string text, TimeSpan patience, CancellationToken stop = default)
        {
            var waited = Stopwatch.StartNew();
            while (!socket.TrySendFrame(Slice, text)) ThrowIfOver(waited, patience, stop);
        }

        /// <summary>The second half: waits for the reply, as <see cref="Request"/> does.</summary>
        /// <param name="patience">How long to wait for the reply.</param>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        /// <returns>The reply's text.</returns>
        public string Receive(TimeSpan patience, CancellationToken stop = default)
        {
            var waited = Stopwatch.StartNew();
            string reply;
            bool more;
            while (!socket.TryReceiveFrameString(waited.Elapsed < Spin ? TimeSpan.Zero : Slice, out reply, out more))
            {
                // NetMQ's own thread may wait for this core.
                Thread.Yield();
                ThrowIfOver(waited, patience, stop);
            }
            // A reply of several frames is one message: its rest must not be taken for the next reply.
            while (more) socket.SkipFrame(out more);
            return reply;
        }

        /// <summary>Between two slices: is it time to end?</summary>
        private void ThrowIfOver(Stopwatch waited, TimeSpan patience, CancellationToken stop)
        {
            stop.ThrowIfCancellationRequested();
            if (waited.Elapsed >= patience)
                throw new TimeoutException(FormattableString.Invariant(
                    $"no reply from {endpoint} within {patience.TotalSeconds} s; is the server running?"));
        }

        /// <summary>Closes the socket, then leaves NetMQ.</summary>
        public void Dispose()
        {
            socket?.Dispose();
            lifetime.Dispose();
        }
    }
}
