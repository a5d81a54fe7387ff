// Lesson 06, many in flight: do not wait for each answer before asking again. Answers come in any order.
//
//     using var requester = new ManyRequester("tcp://127.0.0.1:5556", window: 64);
//     foreach (var answer in requester.RequestMany(texts)) … answer.Number, answer.Reply or answer.Failure …
//
// Take home: this file, NetMQConnection.cs and NetMQLifetime.cs. The Python side is python/06_many_in_flight/server.py.
// Bytes: UTF-8 text, two frames each way: [id][text]. The id is a number in digits; a retry carries the same, so that
// the server does not do twice what it has not answered yet, and a reply that comes late or twice is known and dropped.
// Trouble: see the header of server.py. Stop the server with Ctrl-Z, and within 2 s the client knows; let it work for
// longer than that, and it is slow but not dead.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Globalization;
using System.Linq;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample
{
    /// <summary>
    /// Keeps up to a window of requests under way over one DEALER connection.Socket. Make it, use it and dispose it on one thread,
    /// and not on Unity's main thread.
    /// </summary>
    public sealed class ManyRequester : IDisposable
    {
        /// <summary>What became of one request.</summary>
        public readonly struct Answer
        {
            /// <summary>The request: 1 for the first one.</summary>
            public readonly int Number;
            /// <summary>The reply's text, or null. A text that begins with <c>error:</c> is a reply too.</summary>
            public readonly string Reply;
            /// <summary>The reason why there is no reply, or null. The request may have been done all the same.</summary>
            public readonly string Failure;

            internal Answer(int number, string reply, string failure) => (Number, Reply, Failure) = (number, reply, failure);
        }

        // A socket that met the wrong server may not try again, so after this time without a connection a new one does.
        private static readonly TimeSpan Renew = TimeSpan.FromSeconds(3);
        // No reply has more than two frames. One with more than this many is not read to its end.
        private const int MostFrames = 1000;

        private readonly NetMQConnection connection;
        private readonly Dictionary<int, (int number, string text, TimeSpan deadline, int tries, bool busy)> pending;
        private readonly Stopwatch clock = Stopwatch.StartNew();
        private readonly int window, tries;
        private readonly TimeSpan patience;
        private readonly Action<string> report;
        private int lastId;
        private TimeSpan lonelySince;

        /// <summary>Connects, which succeeds even while no server is there: ZeroMQ goes on trying.</summary>
        /// <param name="endpoint">The server, such as <c>tcp://127.0.0.1:5556</c>.</param>
        /// <param name="window">How many requests may be under way.</param>
        /// <param name="patience">How long each try waits for its reply; 2.5 s when left out.</param>
        /// <param name="tries">How often a request is sent before it is given up.</param>
        /// <param name="report">Called, on the thread of the requests, with a line for each change and each retry.</param>
        /// <exception cref="ArgumentException">The endpoint cannot work; the message names cause and cure.</exception>
        public ManyRequester(string endpoint, int window = 64, TimeSpan? patience = null, int tries = 3, Action<string> report = null)
        {
            if (window < 1 || tries < 1) throw new ArgumentException("window and tries must be 1 or more");
            this.window = window;
            this.patience = patience ?? TimeSpan.FromSeconds(2.5);
            this.tries = tries;
            this.report = report ?? (line => { });
            pending = new Dictionary<int, (int, string, TimeSpan, int, bool)>();
            connection = new NetMQConnection(endpoint, MakeSocket);
        }

        /// <summary>Whether the server is there. A dead one is known within 2 s, and a slow one is not dead.</summary>
        public bool Connected { get; private set; }

        /// <summary>Sends requests, and yields each one's reply or failure once, in the order of their arrival.</summary>
        /// <param name="texts">The requests, sent as UTF-8. The next one is taken when there is room for it, so they may
        /// be endless: whoever makes them has to wait.</param>
        /// <param name="stop">Ends it early, within 50 ms of being cancelled.</param>
        /// <exception cref="OperationCanceledException"><paramref name="stop"/> was cancelled.</exception>
        public IEnumerable<Answer> RequestMany(IEnumerable<string> texts, CancellationToken stop = default)
        {
            pending.Clear();
            using var upcoming = texts.GetEnumerator();
            var number = 0;
            var look = clock.Elapsed + NetMQConnection.Slice;
            while (true)
            {
                while (pending.Count < window && upcoming.MoveNext())
                {
                    pending[++lastId] = (++number, upcoming.Current, clock.Elapsed + patience, 1, false);
                    Send(lastId);
                }
                if (pending.Count == 0) yield break;
                stop.ThrowIfCancellationRequested();
                // The first reply is waited for; what came along with it is there already.
                for (var wait = NetMQConnection.Slice; TryReceive(wait, out var answer); wait = TimeSpan.Zero)
                    if (answer.Number > 0) yield return answer;
                if (clock.Elapsed < look) continue;
                WatchConnection();
                foreach (var id in pending.Keys.Where(id => pending[id].deadline <= clock.Elapsed).ToArray())
                    if (TryAgain(id, out var failed)) yield return failed;
                look = clock.Elapsed + NetMQConnection.Slice;
            }
        }

        /// <summary>Closes the socket, then leaves NetMQ.</summary>
        public void Dispose() => connection.Dispose();

        private void OpenAgain()
        {
            if (Connected) report("lost the server");
            Connected = false;
            lonelySince = clock.Elapsed;
            connection.Close();
            try { _ = connection.Socket; }
            catch (ArgumentException) { /* Its name cannot be looked up just now: it is not there. */ }
        }

        private static DealerSocket MakeSocket() => new DealerSocket
        {
            Options =
            {
                // Asks a silent server every 0.5 s whether it is there, and takes it for dead when 1 s brings no answer.
                HeartbeatInterval = TimeSpan.FromSeconds(0.5),
                HeartbeatTimeout = TimeSpan.FromSeconds(1),
                // It can send only while a server is there; so whether it can, says whether the server is there.
                DelayAttachOnConnect = true,
                // The window is the limit of what is under way. A second one would look like a server that is gone.
                SendHighWatermark = 0,
            },
        };

        /// <summary>False when no message is there. A message that answers nothing gives an answer with number 0.</summary>
        private bool TryReceive(TimeSpan wait, out Answer answer)
        {
            answer = default;
            if (!connection.Socket.TryReceiveFrameString(wait, out var frame, out var more)) return false;
            var reply = "";
            var frames = 1;
            // The frames of a message arrive together: none is waited for. What is left of too many goes with the connection.Socket.
            for (; more; frames++)
            {
                if (frames < MostFrames && connection.Socket.TryReceiveFrameString(out reply, out more)) continue;
                OpenAgain();
                return false;
            }
            // One for a request that is not pending is late or a second one.
            if (frames != 2 || !int.TryParse(frame, NumberStyles.None, CultureInfo.InvariantCulture, out var id)) return true;
            if (!pending.TryGetValue(id, out var entry)) return true;
            if (reply.StartsWith("error: busy", StringComparison.Ordinal))
            {
                // Refused, so it is not done: it is asked again when its patience is over.
                entry.busy = true;
                pending[id] = entry;
                return true;
            }
            pending.Remove(id);
            answer = new Answer(entry.number, reply, null);
            return true;
        }

        private void WatchConnection()
        {
            if (connection.Socket.HasOut == Connected)
            {
                if (!Connected && clock.Elapsed > lonelySince + Renew) OpenAgain();
                return;
            }
            Connected = !Connected;
            lonelySince = clock.Elapsed;
            report(Connected ? "connected" : "lost the server");
            // What the last connection took along is sent again with its old id, and what had none for the first time.
            foreach (var id in pending.Keys) Send(id);
        }

        /// <summary>True when the last try was in vain as well.</summary>
        private bool TryAgain(int id, out Answer failed)
        {
            var entry = pending[id];
            var seconds = FormattableString.Invariant($"{patience.TotalSeconds} s");
            if (entry.tries == tries)
            {
                var cause = entry.busy ? "is busy" : Connected ? "is there, and slow" : "is not there";
                failed = new Answer(entry.number, null, $"no reply in {tries} tries of {seconds}; the server {cause}");
                return pending.Remove(id);
            }
            failed = default;
            pending[id] = (entry.number, entry.text, clock.Elapsed + patience, ++entry.tries, false);
            report($"{entry.number}: no reply within {seconds}; try {entry.tries} of {tries}");
            Send(id);
            return false;
        }

        private void Send(int id)
        {
            // Without a server it waits for the next connection, or for the next try.
            if (Connected && connection.Socket.TrySendFrame(TimeSpan.Zero, id.ToString(CultureInfo.InvariantCulture), true) &&
                !connection.Socket.TrySendFrame(TimeSpan.Zero, pending[id].text))
                OpenAgain();
        }
    }
}
