// Lesson 06, many in flight: no request waits for the reply to another. Replies come in any order.
//
//     using var requester = new ManyRequester("tcp://127.0.0.1:5556", window: 64);
//     foreach (var answer in requester.RequestMany(texts)) … answer.Number, answer.Reply or answer.Failure …
//
// The Python side is python/06_many_in_flight/server.py.
// Bytes: UTF-8 text, two frames each way: [id][text]. The id is NUMBER-NAME, the name 32 hex digits made once for each
// requester, so that no two clients and no two starts have the same: a server that remembers answers gives nobody
// another's. A retry carries the same id, so that the server does not do twice what is at work, and a late or duplicate
// reply is recognised and dropped. The server is
// a ROUTER: a REP takes no message without REQ's empty frame.
// Trouble: see the header of server.py, or kill the server and start it again.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Globalization;
using System.Linq;
using System.Text;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample
{
    /// <summary>Keeps up to a window of requests under way over one DEALER socket at a time. Make it, use it and
    /// dispose it on one thread, and not on Unity's main thread.</summary>
    public sealed class ManyRequester : IDisposable
    {
        /// <summary>The outcome of one request.</summary>
        public readonly struct Answer
        {
            /// <summary>The request: 1 for the first one.</summary>
            public readonly int Number;
            /// <summary>The reply's text, or null. A text that begins with <c>error:</c> is a reply too.</summary>
            public readonly string Reply;
            /// <summary>Why there is no reply, or null. The request may have been done all the same.</summary>
            public readonly string Failure;

            internal Answer(int number, string reply, string failure)
            {
                Number = number;
                Reply = reply;
                Failure = failure;
            }
        }

        // The bytes of the largest request. The server disconnects whoever sends more, with all that is under way.
        private const int LargestBytes = 65536;
        // So many waiting messages are read at a time.
        private const int MostMessages = 1000;
        private readonly Dictionary<string, (int number, string text, TimeSpan sent, int tries)> pending;
        private readonly Stopwatch clock = Stopwatch.StartNew();
        private readonly NetMQConnection connection;
        private readonly OneAtATime calls = new OneAtATime(nameof(ManyRequester));
        private readonly int window, tries;
        private readonly TimeSpan timeout;
        private readonly Action<string> report;
        // The end of every id: an id must never come twice, whoever else asks and however often this program starts.
        private readonly string name = $"-{Guid.NewGuid():N}";
        private readonly string endpoint;
        private int lastId;
        // When something was received last, or a new socket was made.
        private TimeSpan heard;

        /// <summary>Connects, which succeeds even while no server is there: ZeroMQ goes on trying.</summary>
        /// <param name="endpoint">The server, such as <c>tcp://127.0.0.1:5556</c>.</param>
        /// <param name="window">How many requests may be under way.</param>
        /// <param name="timeout">How long the first try waits for its reply; 2.5 s when left out. Each try waits
        /// twice as long as the one before, up to 8 times.</param>
        /// <param name="tries">How often a request is sent before it is given up.</param>
        /// <param name="report">Called, on the thread of the requests, with a line for each retry, unless it is
        /// null.</param>
        /// <exception cref="ArgumentException">One of them cannot work; the message names cause and cure.</exception>
        public ManyRequester(string endpoint, int window = 64, TimeSpan? timeout = null, int tries = 3,
            Action<string> report = null)
        {
            this.endpoint = endpoint;
            this.window = Require.Count("window", window);
            this.tries = Require.Count("tries", tries);
            this.timeout = Require.Seconds("timeout", timeout ?? TimeSpan.FromSeconds(2.5));
            this.report = report ?? (line => { });
            pending = new Dictionary<string, (int, string, TimeSpan, int)>();
            // The window is the limit of what is under way; no second one is needed.
            connection = new NetMQConnection(endpoint, () => new DealerSocket { Options = { SendHighWatermark = 0 } });
        }

        /// <summary>Sends requests, and yields each one's reply or failure once, in order of arrival.</summary>
        /// <param name="texts">The requests, sent as UTF-8. The next one is taken when there is room for it, so they
        /// may be endless; but whatever makes them must not wait: no reply is read meanwhile.</param>
        /// <param name="stop">Ends it early, within 50 ms of being cancelled.</param>
        /// <exception cref="OperationCanceledException"><paramref name="stop"/> was cancelled.</exception>
        /// <exception cref="InvalidOperationException">The requests before these have not all ended.</exception>
        public IEnumerable<Answer> RequestMany(IEnumerable<string> texts, CancellationToken stop = default)
        {
            using var alone = calls.Begin();
            pending.Clear();
            using var upcoming = Require.Given("texts", texts).GetEnumerator();
            var number = 0;
            var look = clock.Elapsed + NetMQConnection.Slice;
            // The caller's work on one outcome is not the server's time, so the others wait here.
            var outcomes = new Queue<Answer>();
            while (true)
            {
                while (pending.Count + outcomes.Count < window && upcoming.MoveNext())
                {
                    number++;
                    var text = Require.Given("each of the texts", upcoming.Current);
                    var size = Encoding.UTF8.GetByteCount(text);
                    if (size <= LargestBytes)
                        Send((++lastId).ToString(CultureInfo.InvariantCulture) + name, number, text, 1);
                    else
                        yield return new Answer(
                            number, null, $"not sent: {size} bytes, and the limit is {LargestBytes}");
                }
                if (pending.Count + outcomes.Count == 0) yield break;
                stop.ThrowIfCancellationRequested();
                Receive(outcomes);
                if (clock.Elapsed >= look)
                {
                    foreach (var id in Overdue())
                        if (GivenUp(id, out var failed)) outcomes.Enqueue(failed);
                    look = clock.Elapsed + NetMQConnection.Slice;
                }
                if (outcomes.Count > 0) yield return outcomes.Dequeue();
            }
        }

        public override string ToString() => $"ManyRequester {endpoint}";
        public void Dispose() => connection.Dispose();

        /// <summary>The replies that are there. If the caller has all before, the first one is waited for.</summary>
        private void Receive(Queue<Answer> outcomes)
        {
            List<byte[]> received = null;
            var wait = outcomes.Count > 0 ? TimeSpan.Zero : NetMQConnection.Slice;
            // A server may send faster than this loop takes.
            for (var i = 0; i < MostMessages; i++)
            {
                if (!connection.Socket.TryReceiveMultipartBytes(wait, ref received)) return;
                wait = TimeSpan.Zero;
                heard = clock.Elapsed;
                connection.Show(false, received);
                var frames = received.ConvertAll(NetMQConnection.Text);
                // One for a request that is not pending is late or a second one: dropped. So is a refusal, until the
                // last try: such a request is asked again when its timeout is over.
                if (frames.Count != 2 || !pending.TryGetValue(frames[0], out var entry)
                    || (entry.tries < tries && frames[1].StartsWith("error: busy", StringComparison.Ordinal))) continue;
                pending.Remove(frames[0]);
                outcomes.Enqueue(new Answer(entry.number, frames[1], null));
            }
        }

        private void Send(string id, int number, string text, int attempt)
        {
            pending[id] = (number, text, clock.Elapsed, attempt);
            // After a peer that broke the protocol there is nothing to send on. Then the next try has a new socket.
            connection.TrySend(TimeSpan.Zero, default, id, text);
        }

        private TimeSpan Timeout(int attempt) => NetMQConnection.Longer(timeout, attempt - 1);

        /// <summary>The ids of what has waited for too long.</summary>
        private string[] Overdue()
        {
            var now = clock.Elapsed;
            var late = pending.Where(p => p.Value.sent + Timeout(p.Value.tries) <= now).Select(p => p.Key).ToArray();
            if (late.All(id => pending[id].sent < heard)) return late;
            // Not a word since then, neither to it nor to others: a new socket helps, whatever is wrong with this one.
            connection.Close();
            heard = clock.Elapsed;
            // All that was under way on it is lost. To send it again before its timeout is over is not another try.
            foreach (var id in pending.Keys.Except(late).ToArray())
                Send(id, pending[id].number, pending[id].text, pending[id].tries);
            return late;
        }

        /// <summary>Sends a request again with its old id. True when the last try was in vain as well.</summary>
        private bool GivenUp(string id, out Answer failed)
        {
            var (number, text, _, attempt) = pending[id];
            var seconds = FormattableString.Invariant($"{Timeout(attempt).TotalSeconds} s");
            var why = $"no reply in {NetMQConnection.Tries(tries)} of up to {seconds}; "
                + connection.Cure("is the server running, slow, or its reply over 64 KB?");
            failed = new Answer(number, null, why);
            if (attempt == tries) return pending.Remove(id);
            report($"{number}: no reply within {seconds}; try {attempt + 1} of {tries}");
            Send(id, number, text, attempt + 1);
            return false;
        }
    }
}
