// Lesson 02, the lazy pirate: retry until there is a reply, and have the work done only once.
//
//     using var requester = new LazyPirateRequester("tcp://127.0.0.1:5552", report: Console.WriteLine);
//     var reply = requester.Request("add 1");    // or a TimeoutException; each retry is a line for report
//
// The Python side is python/02_lazy_pirate/server.py.
// Bytes: UTF-8 text, two frames each way: [id][text]. Every retry of a request carries the same id, by which the
// server knows that it has done it already.
// Trouble: start the server with --crash-on 3 or --drop 3, or kill it and start it again.
using System;
using System.Collections.Generic;
using System.Threading;
using NetMQ.Sockets;
using Stopwatch = System.Diagnostics.Stopwatch;

namespace NetMQExample
{
    /// <summary>Asks a server over one REQ socket at a time, again and again. Make it, use it and dispose it on one
    /// thread, and not on Unity's main thread: a request blocks until it is answered or given up.</summary>
    public sealed class LazyPirateRequester : IDisposable
    {
        // Before a request is sent again after a wrong reply: without it, 5 tries are over in a millisecond.
        private static readonly TimeSpan Pause = TimeSpan.FromMilliseconds(250);

        // An id must never come twice, whoever else asks and however often this program starts: hence the GUID.
        private readonly string name = Guid.NewGuid().ToString("N");
        private readonly NetMQConnection connection;
        private readonly OneAtATime calls = new OneAtATime(nameof(LazyPirateRequester));
        private readonly string endpoint;
        private readonly TimeSpan timeout;
        private readonly int tries;
        private readonly Action<string> report;
        private int number;

        /// <summary>Connects, which succeeds even while no server is there: ZeroMQ goes on trying.</summary>
        /// <param name="endpoint">The server, such as <c>tcp://127.0.0.1:5552</c>.</param>
        /// <param name="timeout">How long to wait for the reply to the first try; 0.5 s when left out. Each try waits
        /// twice as long as the one before, at most 8 times as long as the first.</param>
        /// <param name="tries">How often to send a request before giving up.</param>
        /// <param name="report">Called, on the thread of the request, with a line to log before each retry, unless it
        /// is null.</param>
        /// <exception cref="ArgumentException">One of them cannot work; the message names cause and cure.</exception>
        public LazyPirateRequester(
            string endpoint, TimeSpan? timeout = null, int tries = 5, Action<string> report = null)
        {
            this.endpoint = endpoint;
            this.timeout = Require.Seconds("timeout", timeout ?? TimeSpan.FromSeconds(0.5));
            this.tries = Require.Count("tries", tries);
            this.report = report ?? (line => { });
            connection = new NetMQConnection(endpoint, () => new RequestSocket());
        }

        /// <summary>Sends a request until it is answered.</summary>
        /// <param name="text">The request, sent as UTF-8.</param>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        /// <param name="within">How long all tries take together, at most; without it as long as each may.</param>
        /// <exception cref="TimeoutException">No try was answered. The request may have been done all the
        /// same.</exception>
        /// <exception cref="OperationCanceledException"><paramref name="stop"/> was cancelled.</exception>
        /// <exception cref="ArgumentException">The text has more than 65,536 bytes.</exception>
        public string Request(string text, CancellationToken stop = default, TimeSpan? within = null)
        {
            Require.Text("text", text);
            if (within != null) Require.Seconds("within", within.Value);
            using var alone = calls.Begin();
            var id = $"{++number}-{name}";
            var waited = Stopwatch.StartNew();
            for (var attempt = 1; ; attempt++)
            {
                var limit = NetMQConnection.Longer(timeout, attempt - 1);
                // In whole milliseconds, as the line says it.
                var left = Math.Ceiling(((within ?? TimeSpan.MaxValue) - waited.Elapsed).TotalMilliseconds);
                var last = attempt == tries || left <= limit.TotalMilliseconds;
                if (left < limit.TotalMilliseconds) limit = TimeSpan.FromMilliseconds(Math.Max(0, left));
                if (Try(id, text, limit, stop, out var frames)) return frames[1];
                var missing = connection.Unanswered ? "nobody answers to this name" : "no reply";
                var trouble = frames == null
                    ? FormattableString.Invariant($"{missing} within {limit.TotalSeconds} s")
                    : $"dropped a reply to another request ({LogText.Printable(string.Join(" ", frames))})";
                var all = within == null ? "" : FormattableString.Invariant($" within {within.Value.TotalSeconds} s");
                if (last)
                    throw new TimeoutException($"{NetMQConnection.Tries(attempt)}{all} to ask {endpoint}, the last: "
                        + $"{trouble}; "
                        + connection.Cure("is the right server running, the line slow, or the reply over 64 KB?")
                        + $" '{text}' may have been done or not");
                report($"{number}: {trouble}; try {attempt + 1} of {tries}");
            }
        }

        public override string ToString() => $"LazyPirateRequester {endpoint}";
        public void Dispose() => connection.Dispose();

        // One try, with the frames that came back, if any.
        private bool Try(string id, string text, TimeSpan limit, CancellationToken stop, out List<string> frames)
        {
            var waited = Stopwatch.StartNew();
            var answered = false;
            frames = null;
            try
            {
                // Without waiting: after a peer that broke the protocol there may be no connection to send on.
                answered = connection.TrySend(connection.Searching ? limit : TimeSpan.Zero, stop, id, text)
                    && connection.TryReceive(limit, stop, out frames) && frames.Count == 2 && frames[0] == id;
                var rest = limit - waited.Elapsed;
                if (!answered && rest > TimeSpan.Zero) stop.WaitHandle.WaitOne(rest < Pause ? rest : Pause);
            }
            finally
            {
                // A REQ socket that waits for a reply refuses to send. A new one may, on a new connection.
                if (!answered) connection.Close();
            }
            return answered;
        }
    }
}
