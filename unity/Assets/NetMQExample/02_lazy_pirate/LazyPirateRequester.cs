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
        /// <param name="patience">How long to wait for the reply to each try.</param>
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
            for (var attempt = 1; attempt <= tries; attempt++)
            {
                if (socket == null) Connect();
                socket.SendMoreFrame(id).SendFrame(text);
                var trouble = Receive(id, stop, out var reply);
                if (trouble == null) return reply;
                // A REQ socket that waits for a reply refuses to send. A new one may, on a new connection.
                if (!relaxed) Close();
                stop.ThrowIfCancellationRequested();
                var how = relaxed ? "on the same socket" : "on a new socket";
                if (attempt < tries) report($"{number}: {trouble}; try {attempt + 1} of {tries}, {how}");
            }
            throw new TimeoutException(FormattableString.Invariant(
                $"no reply from {endpoint} in {tries} tries of {patience.TotalSeconds} s; is the server running? ")
                + $"'{text}' may have been done or not");
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

        /// <summary>Waits for the reply; returns what went wrong, or null.</summary>
        private string Receive(string id, CancellationToken stop, out string reply)
        {
            reply = null;
            NetMQMessage message = null;
            var waited = Stopwatch.StartNew();
            do
            {
                var left = patience - waited.Elapsed;
                // NetMQ waits for ever when it is asked to wait for less than a millisecond.
                if (left < Least || stop.IsCancellationRequested)
                    return FormattableString.Invariant($"no reply within {patience.TotalSeconds} s");
                socket.TryReceiveMultipartMessage(left < Slice ? left : Slice, ref message);
            }
            while (message == null);
            // Without the encoding, NetMQ makes a question mark of every byte that is not ASCII.
            var frames = message.Select(frame => frame.ConvertToString(Encoding.UTF8)).ToArray();
            // A late reply to an earlier request. Taken for this one's, it would shift all that follow by one.
            if (frames.Length != 2 || frames[0] != id)
                return $"dropped a reply to another request ({string.Join(" ", frames)})";
            reply = frames[1];
            return null;
        }
    }
}
