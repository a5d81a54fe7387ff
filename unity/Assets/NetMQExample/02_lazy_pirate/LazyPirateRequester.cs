// Lesson 02, the lazy pirate: ask again until it is answered, and have it done only once.
//
// Take home: this file and NetMQLifetime.cs of lesson 01. The Python side is python/02_lazy_pirate/server.py.
// Bytes: UTF-8 text, two frames each way: [id][text]. Every retry of a request carries the same id, by which the
// server knows that it has done it already.
// Trouble: start the server with --crash-on 3, --drop 3, --slow-on 3 or --late 3, or kill it and start it again.
using System;
using System.Diagnostics;
using System.Linq;
using System.Text;
using System.Text.RegularExpressions;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample
{
    /// <summary>
    /// Asks a server over one REQ socket at a time, again and again. Make it, use it and dispose it on one thread, and
    /// not on Unity's main thread: a request blocks until it is answered or given up.
    /// </summary>
    public sealed class LazyPirateRequester : IDisposable
    {
        // Short enough that Stop in the editor is felt at once, long enough to cost nothing.
        private static readonly TimeSpan Slice = TimeSpan.FromMilliseconds(50);
        private static readonly TimeSpan Least = TimeSpan.FromMilliseconds(1);
        // Before a request is sent again after a wrong reply: without it, 5 tries are over in a millisecond.
        private static readonly TimeSpan Pause = TimeSpan.FromMilliseconds(250);

        private readonly NetMQLifetime lifetime = new NetMQLifetime();
        // An id must never come twice, whoever else asks and however often this program starts: hence the GUID.
        private readonly string name = Guid.NewGuid().ToString("N");
        private readonly string endpoint;
        private readonly TimeSpan patience;
        private readonly int tries;
        private readonly bool relaxed;
        private readonly Action<string> report;
        private RequestSocket socket;
        private int number;

        /// <summary>Connects, which succeeds even while no server is there: ZeroMQ goes on trying.</summary>
        /// <param name="endpoint">The server, such as <c>tcp://127.0.0.1:5552</c>.</param>
        /// <param name="patience">How long to wait for the reply to the first try. Each try waits twice as long as the
        /// one before, at most 8 times as long as the first.</param>
        /// <param name="tries">How often to send a request before giving up.</param>
        /// <param name="report">Called, on the thread of the request, with a line for each retry.</param>
        /// <param name="relaxed">Keep the socket for the next try, instead of making a new one.</param>
        /// <exception cref="ArgumentException">The endpoint cannot work; the message names cause and cure.</exception>
        public LazyPirateRequester(string endpoint, TimeSpan patience, int tries, Action<string> report, bool relaxed = false)
        {
            this.endpoint = endpoint;
            this.patience = patience;
            this.tries = tries;
            this.report = report;
            this.relaxed = relaxed;
            try
            {
                if (tries < 1 || patience <= TimeSpan.Zero)
                    throw new ArgumentException("tries must be 1 or more, and patience longer than 0 s");
                Connect();
            }
            catch
            {
                Dispose();
                throw;
            }
        }

        /// <summary>Sends a request until it is answered.</summary>
        /// <param name="text">The request, sent as UTF-8.</param>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        /// <returns>The reply's text.</returns>
        /// <exception cref="TimeoutException">No try was answered. The request may have been done all the same.</exception>
        /// <exception cref="OperationCanceledException"><paramref name="stop"/> was cancelled.</exception>
        public string Request(string text, CancellationToken stop = default)
        {
            // Here too, so that nothing is sent any more.
            stop.ThrowIfCancellationRequested();
            var id = $"{name}-{++number}";
            string trouble = null, hint = null;
            for (var attempt = 1; attempt <= tries; attempt++)
            {
                if (socket == null) Connect();
                // A new connection takes several round trips. On a slow line only a longer wait ever succeeds.
                var limit = TimeSpan.FromTicks(patience.Ticks << Math.Min(attempt - 1, 3));
                var frames = Exchange(id, text, limit, stop);
                if (frames == null)
                {
                    trouble = FormattableString.Invariant($"no reply within {limit.TotalSeconds} s");
                    hint = "is the server running, or the line slow?";
                }
                else if (frames.Length == 2 && frames[0] == id)
                {
                    return frames[1];
                }
                else
                {
                    // A late reply to an earlier request. Taken for this one's, it would shift all that follow by one.
                    trouble = $"dropped a reply to another request ({Short(string.Join(" ", frames))})";
                    hint = "is it the right server?";
                    // It may have come at once, and so may the next.
                    stop.WaitHandle.WaitOne(Pause);
                }
                // A REQ socket that waits for a reply refuses to send. A new one may, on a new connection.
                if (!relaxed) Close();
                stop.ThrowIfCancellationRequested();
                var how = relaxed ? "on the same socket" : "on a new socket";
                if (attempt < tries) report($"{number}: {trouble}; try {attempt + 1} of {tries}, {how}");
            }
            throw new TimeoutException(
                $"{tries} tries to ask {endpoint}, the last: {trouble}; {hint} '{text}' may have been done or not");
        }

        /// <summary>Closes the socket, then leaves NetMQ.</summary>
        public void Dispose()
        {
            Close();
            lifetime.Dispose();
        }

        private void Close()
        {
            socket?.Dispose();
            socket = null;
        }

        private void Connect()
        {
            socket = new RequestSocket();
            // A request that nobody fetched is dropped with its socket; waiting for its delivery could take for ever.
            socket.Options.Linger = TimeSpan.Zero;
            // A peer that announces more is disconnected before it is in memory.
            socket.Options.MaxMsgSize = 65536;
            if (relaxed)
            {
                // May send again without a reply, and numbers what it sends, so that only the newest try is answered.
                socket.Options.Relaxed = true;
                socket.Options.Correlate = true;
                // Tries pile up while no server is there. At the usual limit, a thousand, a send would wait for ever.
                socket.Options.SendHighWatermark = 0;
            }
            NetMQLifetime.Connect(socket, endpoint);
        }

        /// <summary>One try: the frames of a reply, whichever it is, or null.</summary>
        private string[] Exchange(string id, string text, TimeSpan limit, CancellationToken stop)
        {
            // Without the encoding, NetMQ makes a question mark of every character that is not ASCII.
            var request = new NetMQMessage();
            request.Append(id, Encoding.UTF8);
            request.Append(text, Encoding.UTF8);
            if (!socket.TrySendMultipartMessage(TimeSpan.Zero, request))
            {
                // Nothing to send it on: after a peer that broke the protocol, libzmq does not connect again.
                Close();
                Connect();
                socket.TrySendMultipartMessage(TimeSpan.Zero, request);
            }
            NetMQMessage reply = null;
            var waited = Stopwatch.StartNew();
            do
            {
                var left = limit - waited.Elapsed;
                // NetMQ waits for ever when it is asked to wait for less than a millisecond.
                if (left < Least || stop.IsCancellationRequested) return null;
                socket.TryReceiveMultipartMessage(left < Slice ? left : Slice, ref reply);
            }
            while (reply == null);
            return reply.Select(frame => frame.ConvertToString(Encoding.UTF8)).ToArray();
        }

        /// <summary>A reply with its id, as it is printed: of the long random number, the beginning is enough.</summary>
        private static string Short(string text) =>
            Regex.Replace(NetMQLifetime.Printable(text), "^([0-9a-f]{8})[0-9a-f]{24}-", "$1…-");
    }
}
