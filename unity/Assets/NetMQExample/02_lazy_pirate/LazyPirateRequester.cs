// Lesson 02, the lazy pirate: ask again until it is answered, and have it done only once.
//
// Take home: this file, NetMQConnection.cs and NetMQLifetime.cs. The Python side is python/02_lazy_pirate/server.py.
// Bytes: UTF-8 text, two frames each way: [id][text]. Every retry of a request carries the same id, by which the
// server knows that it has done it already.
// Trouble: start the server with --crash-on 3, --drop 3, --slow-on 3 or --late 3, or kill it and start it again.
using System;
using System.Collections.Generic;
using System.Text.RegularExpressions;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample
{
    /// <summary>A request has no reply: in one try, as it is reported, or in none of them, as it is thrown.</summary>
    public sealed class NoReplyException : TimeoutException
    {
        internal NoReplyException(string message, int attempt, TimeSpan limit, bool wrong) : base(message) =>
            (Attempt, Limit, Wrong) = (attempt, limit, wrong);

        /// <summary>Which try was in vain; 1 for the first.</summary>
        public int Attempt { get; }

        /// <summary>How long it waited at most.</summary>
        public TimeSpan Limit { get; }

        /// <summary>True if something came that is no reply to this request.</summary>
        public bool Wrong { get; }
    }

    /// <summary>
    /// Asks a server over one REQ socket at a time, again and again. Make it, use it and dispose it on one thread, and
    /// not on Unity's main thread: a request blocks until it is answered or given up.
    /// </summary>
    public sealed class LazyPirateRequester : IDisposable
    {
        // Before a request is sent again after a wrong reply: without it, 5 tries are over in a millisecond.
        private static readonly TimeSpan Pause = TimeSpan.FromMilliseconds(250);

        // An id must never come twice, whoever else asks and however often this program starts: hence the GUID.
        private readonly string name = Guid.NewGuid().ToString("N");
        private readonly NetMQConnection connection;
        private readonly string endpoint;
        private readonly TimeSpan patience;
        private readonly int tries;
        private readonly bool relaxed;
        private readonly Action<NoReplyException> report;
        private int number;

        /// <summary>Connects, which succeeds even while no server is there: ZeroMQ goes on trying.</summary>
        /// <param name="endpoint">The server, such as <c>tcp://127.0.0.1:5552</c>.</param>
        /// <param name="patience">How long to wait for the reply to the first try. Each try waits twice as long as the
        /// one before, at most 8 times as long as the first.</param>
        /// <param name="tries">How often to send a request before giving up.</param>
        /// <param name="report">Called, on the thread of the request, before each retry; the message is a line to log.</param>
        /// <param name="relaxed">Keep the socket for the next try, instead of making a new one.</param>
        /// <exception cref="ArgumentException">The endpoint cannot work; the message names cause and cure.</exception>
        public LazyPirateRequester(string endpoint, TimeSpan patience, int tries,
            Action<NoReplyException> report, bool relaxed = false)
        {
            if (tries < 1 || patience <= TimeSpan.Zero)
                throw new ArgumentException("tries must be 1 or more, and patience longer than 0 s");
            (this.endpoint, this.patience, this.tries) = (endpoint, patience, tries);
            (this.report, this.relaxed) = (report, relaxed);
            connection = new NetMQConnection(endpoint, () => relaxed ? MakeRelaxed() : new RequestSocket());
        }

        /// <summary>Sends a request until it is answered.</summary>
        /// <param name="text">The request, sent as UTF-8.</param>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        /// <returns>The reply's text.</returns>
        /// <exception cref="NoReplyException">No try was answered. The request may have been done all the same.</exception>
        /// <exception cref="OperationCanceledException"><paramref name="stop"/> was cancelled.</exception>
        public string Request(string text, CancellationToken stop = default)
        {
            var id = $"{name}-{++number}";
            for (var attempt = 1; ; attempt++)
            {
                // A new connection takes several round trips. On a slow line only a longer wait ever succeeds.
                var limit = TimeSpan.FromTicks(patience.Ticks << Math.Min(attempt - 1, 3));
                if (Try(id, text, limit, stop, out var frames)) return frames[1];
                // A wrong reply may have come at once, and so may the next.
                if (frames != null) stop.WaitHandle.WaitOne(Pause);
                stop.ThrowIfCancellationRequested();
                var (trouble, hint) = frames == null
                    ? (FormattableString.Invariant($"no reply within {limit.TotalSeconds} s"),
                        "is the server running, or the line slow?")
                    : ($"dropped a reply to another request ({Short(string.Join(" ", frames))})", "is it the right server?");
                NoReplyException InVain(string message) =>
                    new NoReplyException(message, attempt, limit, frames != null);
                if (attempt == tries)
                    throw InVain($"{tries} tries to ask {endpoint}, the last: {trouble}; {hint} "
                        + $"'{text}' may have been done or not");
                var how = relaxed ? "on the same socket" : "on a new socket";
                report(InVain($"{number}: {trouble}; try {attempt + 1} of {tries}, {how}"));
            }
        }

        /// <summary>Closes the socket, then leaves NetMQ.</summary>
        public void Dispose() => connection.Dispose();

        // One try. Its frames are those of a wrong reply if it is in vain, or null.
        private bool Try(string id, string text, TimeSpan limit, CancellationToken stop, out List<string> frames)
        {
            var answered = false;
            try
            {
                // Where there is nothing to send on, as after a peer that broke the protocol, only a new socket helps.
                if (!connection.TrySend(TimeSpan.Zero, stop, id, text))
                {
                    connection.Close();
                    connection.Send(limit, stop, id, text);
                }
                // A late reply to an earlier request, taken for this one's, would shift all that follow by one.
                answered = connection.TryReceive(limit, stop, out frames) && frames.Count == 2 && frames[0] == id;
            }
            finally
            {
                // A REQ socket that waits for a reply refuses to send. A new one may, on a new connection.
                if (!answered && !relaxed) connection.Close();
            }
            return answered;
        }

        private static NetMQSocket MakeRelaxed() => new RequestSocket
        {
            Options =
            {
                // It may send again without a reply, and numbers what it sends: only the newest try is answered.
                Relaxed = true,
                Correlate = true,
                // Tries pile up while no server is there. At the usual limit, a thousand, a send would wait for ever.
                SendHighWatermark = 0,
            },
        };

        /// <summary>A reply with its id, as it is printed: of the long random number, the beginning is enough.</summary>
        private static string Short(string text) =>
            Regex.Replace(NetMQLifetime.Printable(text), "^([0-9a-f]{8})[0-9a-f]{24}-", "$1…-");
    }
}
