// Lesson 14, the job's client: starts a job or comes back to it, watches and cancels it.
//
//     using var client = new JobClient("tcp://127.0.0.1:5564", report: log);      or, of a job that is there: job: id
//     foreach (var news in client.Watch(client.Goal("picture", 100), stop))        or: client.Ask("status")
//         log(news.Line);                                          client.Cancel() in between, on any thread
//
// The Python side is python/14_long_jobs/server.py, whose header says what the bytes are.
// The client repeats its request, and the server begins no job twice. So lost messages and restarts of either side do
// no harm. The news is the newest state; the last message is the result.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Text.RegularExpressions;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;
using Stopwatch = System.Diagnostics.Stopwatch;

namespace NetMQExample
{
    /// <summary>One job, over one DEALER socket at a time. Make it, use it and dispose it on one thread, and not on
    /// Unity's main thread: to watch is to wait.</summary>
    public sealed class JobClient : IDisposable
    {
        // The server tells what is new for five seconds after it was asked.
        private static readonly TimeSpan Again = TimeSpan.FromSeconds(1);

        private readonly NetMQConnection connection;
        private readonly OneAtATime calls = new OneAtATime(nameof(JobClient));
        private readonly string endpoint;
        private readonly TimeSpan timeout;
        private readonly int tries;
        private readonly Action<string> report;
        private int cancel;
        // The fault of a message of this try.
        private string dropped;

        /// <summary>Connects, which succeeds even while no server is there: ZeroMQ goes on trying.</summary>
        /// <param name="endpoint">The server, such as <c>tcp://127.0.0.1:5564</c>.</param>
        /// <param name="job">The id of a job to come back to; a new one when left out.</param>
        /// <param name="timeout">How long to wait for a word of the job before connecting anew, 1 s when left out. Each
        /// try waits twice as long as the one before, up to 8 times.</param>
        /// <param name="tries">How often that may happen in a row before giving up.</param>
        /// <param name="report">Called, on the thread that watches, with a line to log about each trouble, unless it
        /// is null.</param>
        /// <exception cref="ArgumentException">One of them cannot work; the message names cause and cure.</exception>
        public JobClient(string endpoint, string job = null, TimeSpan? timeout = null, int tries = 5,
            Action<string> report = null)
        {
            job ??= NewId();
            if (!Regex.IsMatch(job, "^[0-9A-Za-z][0-9A-Za-z-]{0,63}\\z"))
                throw new ArgumentException("resume takes the id of a job, such as the one that leave-at prints");
            this.endpoint = endpoint;
            Job = job;
            this.timeout = Require.Seconds("timeout", timeout ?? TimeSpan.FromSeconds(1));
            this.tries = Require.Count("tries", tries);
            this.report = report ?? (line => { });
            connection = new NetMQConnection(endpoint, () => new DealerSocket(), Message.LimitBytes);
        }

        public string Job { get; }

        /// <summary>An id must never come twice, whoever else makes one: hence the GUID.</summary>
        public static string NewId() => Guid.NewGuid().ToString("N");

        /// <summary>The request that begins the job, or only watches it if it is there already.</summary>
        /// <exception cref="ArgumentException">The count is below 1.</exception>
        public Message Goal(string kind, int count, string text = "")
        {
            var goal = Ask("goal");
            if (count < 1) throw new ArgumentException("count takes a whole number from 1");
            goal.Values["kind"] = kind;
            goal.Values["count"] = (long)count;
            goal.Values["text"] = text;
            return goal;
        }

        /// <summary>Another request: status, or forget after the end.</summary>
        public Message Ask(string verb)
        {
            var message = new Message(verb);
            message.Values["job"] = Job;
            return message;
        }

        /// <summary>The news of the job, up to its result.</summary>
        /// <param name="stop">Ends the watching, within 50 ms of being cancelled. The job goes on.</param>
        /// <exception cref="MessageException">The server rejects it, with its words; or the job was
        /// forgotten.</exception>
        /// <exception cref="TimeoutException">Nothing came in all tries.</exception>
        public IEnumerable<JobNews> Watch(Message request, CancellationToken stop = default)
        {
            Require.Given("request", request);
            using var alone = calls.Begin();
            var silent = 0;
            var seq = -1L;
            var since = Stopwatch.StartNew();
            // Twice within the timeout: work that has nothing to say for so long is no server that is away.
            var again = timeout / 2 < Again ? timeout / 2 : Again;
            while (true)
            {
                Send(request, stop);
                var repeated = false;
                for (var asked = Stopwatch.StartNew(); asked.Elapsed < again;)
                {
                    if (Interlocked.Exchange(ref cancel, 0) > 0)
                    {
                        request = Ask("cancel");
                        Send(request, stop);
                    }
                    if (!TryReceive(stop, out var news)) continue;
                    var end = news.Kind == "result" || news.Kind == "forgotten";
                    if (news.Kind == "forgotten" && request.Kind != "forget")
                        throw new MessageException("forgotten", "its result was deleted; begin a job with a new id");
                    // The same number was told already: the answer to the same question. A lower one is new, too: the
                    // server has begun the job once more, with another journal.
                    if (!end && news.Seq == seq)
                    {
                        repeated = true;
                        continue;
                    }
                    yield return news;
                    // How long the caller takes for it is no silence of the server's.
                    since.Restart();
                    silent = 0;
                    seq = news.Seq;
                    if (end) yield break;
                }
                // Where its newer words cannot be read, to repeat the old ones is no news.
                if (repeated && dropped == null)
                {
                    silent = 0;
                    since.Restart();
                }
                var wait = NetMQConnection.Longer(timeout, silent);
                if (since.Elapsed < wait) continue;
                var limit = FormattableString.Invariant($"{wait.TotalSeconds} s");
                silent++;
                if (silent == tries)
                    throw new TimeoutException($"no word of it from {endpoint} in {NetMQConnection.Tries(tries)} of "
                        + $"up to {limit}; {dropped ?? connection.Cure("is the server running?")} Its id is {Job}");
                report($"no word within {limit}; try {silent + 1} of {tries}");
                // A new socket helps, whatever was wrong with this one.
                connection.Close();
                dropped = null;
                since.Restart();
            }
        }

        /// <summary>Asks for the job's end, on any thread. It may come too late: the result says what it
        /// became.</summary>
        public void Cancel() => cancel = 1;

        public override string ToString() => $"JobClient {endpoint}";
        public void Dispose() => connection.Dispose();

        // Without waiting: after a peer that broke the protocol there may be no connection to send on.
        private void Send(Message request, CancellationToken stop) =>
            connection.TrySend(TimeSpan.Zero, stop, request.Header());

        // The next message about this job, if one comes soon.
        private bool TryReceive(CancellationToken stop, out JobNews news)
        {
            NetMQMessage frames = null;
            news = null;
            stop.ThrowIfCancellationRequested();
            if (!connection.Socket.TryReceiveMultipartMessage(NetMQConnection.Slice, ref frames)) return false;
            connection.Show(false, frames);
            Message message;
            try
            {
                message = Message.Read(frames.Select(frame =>
                    new ReadOnlyMemory<byte>(frame.Buffer, 0, frame.MessageSize)).ToList());
            }
            catch (MessageException e)
            {
                // One line for each try: many that are wrong must not fill a disk.
                if (dropped == null) report($"dropped: {LogText.Printable(e.Message)}");
                dropped = $"{LogText.Printable(e.Message)}: are both sides of one release?";
                return false;
            }
            if (message.Kind == "rejected")
                throw new MessageException(
                    JobNews.Take<string>(message, "code"), JobNews.Take<string>(message, "text"));
            if (!Job.Equals(message.Values.GetValueOrDefault("job"))) return false;
            news = new JobNews(message);
            return true;
        }
    }
}
