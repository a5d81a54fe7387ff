// Lesson 03, publish-subscribe: listen to a stream, and know of each message that was missed.
//
// Take home: this file, NetMQConnection.cs and NetMQLifetime.cs. The Python side is python/03_publish_subscribe/server.py,
// whose header says the bytes: UTF-8 text, one frame, numbers with a decimal point.
// One rule: a pose that is not the next one calls for a snapshot. It cures joining late, loss and a restart alike.
// Trouble: start the server with --rate 20000 --hwm 100 and this side with --work 0.001, or restart the server.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Globalization;
using System.Numerics;
using System.Text;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample
{
    /// <summary>Where something is, in Unity's metres and axes, and which message said so.</summary>
    public sealed class PoseMessage
    {
        private PoseMessage(string run, long number, float[] n)
        {
            Run = run;
            Number = number;
            Position = new Vector3(n[0], n[1], n[2]);
            Rotation = new Quaternion(n[3], n[4], n[5], n[6]);
        }

        /// <summary>Another one with each start of the publisher, whose numbers begin anew then.</summary>
        public string Run { get; }

        /// <summary>Counts the poses of a run, from 1.</summary>
        public long Number { get; }

        /// <summary>The place.</summary>
        public Vector3 Position { get; }

        /// <summary>The direction.</summary>
        public Quaternion Rotation { get; }

        /// <summary>Reads a message; null if it is no pose, since anybody can publish on a port.</summary>
        public static PoseMessage Parse(string message)
        {
            const NumberStyles plain = NumberStyles.AllowLeadingSign | NumberStyles.AllowDecimalPoint | NumberStyles.AllowExponent;
            // Without the culture, a German machine reads 0.5 as 5.
            var culture = CultureInfo.InvariantCulture;
            var words = message.Split(' ');
            if (words.Length != 10 || words[0] != "pose/" || words[1].Length == 0) return null;
            if (!long.TryParse(words[2], NumberStyles.None, culture, out var number)) return null;
            var n = new float[7];
            for (var i = 0; i < n.Length; i++)
                // A number that no Transform takes is none.
                if (!float.TryParse(words[i + 3], plain, culture, out n[i]) || float.IsNaN(n[i]) || float.IsInfinity(n[i])) return null;
            return new PoseMessage(NetMQLifetime.Printable(words[1]), number, n);
        }

        /// <summary>The line that the lesson's programs print.</summary>
        public override string ToString() => FormattableString.Invariant($"{Number}: at {Position.X:F4} {Position.Y:F4} {Position.Z:F4}");
    }

    /// <summary>
    /// Follows the publisher over a SUB socket. Make it, use it and dispose it on one thread, and not on Unity's main
    /// thread: to receive is to wait.
    /// </summary>
    public sealed class PoseSubscriber : IDisposable
    {
        private static readonly TimeSpan Second = TimeSpan.FromSeconds(1);

        private readonly NetMQConnection connection;
        private readonly string endpoint;
        private readonly string snapshots;
        private readonly Action<string> report;

        /// <summary>Subscribes and connects, which succeeds even while no publisher is there.</summary>
        /// <param name="endpoint">The publisher, such as <c>tcp://127.0.0.1:5553</c>.</param>
        /// <param name="snapshots">Where it gives snapshots; null or empty for the port 100 higher.</param>
        /// <param name="report">Called, on the thread that receives, with a line about what was joined or missed.</param>
        /// <param name="hwm">How many messages may wait here; 0 for any number.</param>
        /// <exception cref="ArgumentException">The endpoint cannot work; the message names cause and cure.</exception>
        public PoseSubscriber(string endpoint, string snapshots, Action<string> report, int hwm = 1000)
        {
            this.endpoint = endpoint;
            this.report = report;
            connection = new NetMQConnection(endpoint, () =>
            {
                var socket = new SubscriberSocket { Options = { ReceiveHighWatermark = hwm } };
                socket.Subscribe("pose/");
                return socket;
            });
            var port = endpoint.LastIndexOf(':') + 1;
            var higher = int.Parse(endpoint.Substring(port), CultureInfo.InvariantCulture) + 100;
            this.snapshots = string.IsNullOrEmpty(snapshots) ? endpoint.Substring(0, port) + higher : snapshots;
            report($"following {endpoint}, snapshots from {this.snapshots}");
        }

        /// <summary>The newest pose; null before the first.</summary>
        public PoseMessage Pose { get; private set; }

        /// <summary>What the publisher's was when it had sent <see cref="Pose"/>: every message counts in it.</summary>
        public uint Checksum { get; private set; }

        /// <summary>How many poses came over the stream.</summary>
        public long Received { get; private set; }

        /// <summary>How many poses did not, and were made up for by a snapshot or skipped for the newest.</summary>
        public long Missed { get; private set; }

        /// <summary>Waits for the next pose.</summary>
        /// <param name="patience">How long to wait for a snapshot, if one is needed.</param>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        /// <returns>False if there is none yet.</returns>
        /// <exception cref="TimeoutException">The publisher is gone.</exception>
        /// <exception cref="OperationCanceledException"><paramref name="stop"/> was cancelled.</exception>
        public bool Receive(TimeSpan patience, CancellationToken stop = default)
        {
            var waited = Stopwatch.StartNew();
            do
            {
                // The lost pose may have been the last one. So a second of silence calls for a snapshot as well.
                var heard = Take(connection.Socket, Second, stop, out var frame);
                var pose = PoseMessage.Parse(Encoding.UTF8.GetString(frame));
                if (pose == null || Pose == null || pose.Run != Pose.Run || pose.Number > Pose.Number + 1)
                {
                    var news = CatchUp(patience, stop);
                    // The publisher went on, and nothing of it came.
                    if (news && !heard && !connection.Socket.HasIn) Reconnect();
                    return news;
                }
                // A lower number was sent before the snapshot was made, and is contained in it.
                if (pose.Number != Pose.Number + 1) continue;
                Pose = pose;
                Checksum *= 31;
                foreach (var b in frame) Checksum += b;
                Received++;
                return true;
            }
            // A publisher that repeats itself must not hold the caller for ever.
            while (waited.Elapsed < Second);
            return false;
        }

        /// <summary>
        /// Waits for a pose, then takes all that wait behind it: only the last one counts. (libzmq can keep the newest
        /// one by itself, with CONFLATE; NetMQ has no such option.)
        /// </summary>
        /// <param name="patience">How long to wait for a pose.</param>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        /// <returns>True.</returns>
        /// <exception cref="TimeoutException">None came.</exception>
        public bool ReceiveNewest(TimeSpan patience, CancellationToken stop = default)
        {
            foreach (var limit in Waits(patience))
            {
                if (!Take(connection.Socket, limit, stop, out var newest) && Pose == null) Reconnect();
                // The limit is for a publisher that sends faster than this loop takes.
                for (var i = 0; i < 10_000 && Take(connection.Socket, TimeSpan.Zero, stop, out var frame); i++) newest = frame;
                var (old, pose) = (Pose, PoseMessage.Parse(Encoding.UTF8.GetString(newest)));
                if (pose == null) continue;
                Pose = pose;
                Received++;
                if (old?.Run == pose.Run) Missed += Math.Max(0, pose.Number - old.Number - 1);
                return true;
            }
            throw new TimeoutException(FormattableString.Invariant(
                $"no pose within {patience.TotalSeconds} s; is the server running, or the line slow?"));
        }

        /// <summary>The last line that the lesson's programs print.</summary>
        /// <exception cref="TimeoutException">Nothing came over the stream, though the publisher sends.</exception>
        public string Summary()
        {
            if (Pose == null || (Missed > 0 && Received == 0))
                throw new TimeoutException($"no pose came over {endpoint}; is that the publisher, and its port open?");
            return $"done: received {Received}, missed {Missed}; run {Pose.Run} at {Pose.Number}, checksum {Checksum}";
        }

        /// <summary>Closes the socket, then leaves NetMQ.</summary>
        public void Dispose() => connection.Dispose();

        /// <summary>Takes over the publisher's state from a snapshot, and says which poses that skips.</summary>
        private bool CatchUp(TimeSpan patience, CancellationToken stop)
        {
            var old = Pose;
            (Checksum, Pose) = Ask(patience, stop);
            if (old == null)
            {
                report($"joined run {Pose.Run} at {Pose.Number}, checksum {Checksum}");
                return true;
            }
            if (Pose.Run != old.Run)
            {
                Missed += Pose.Number;
                report($"missed run {old.Run} from {old.Number + 1} on, and run {Pose.Run} up to {Pose.Number}");
                return true;
            }
            Missed += Pose.Number - old.Number;
            if (Pose.Number > old.Number) report($"missed {old.Number + 1} to {Pose.Number}");
            return Pose.Number > old.Number;
        }

        /// <summary>A snapshot from the publisher: checksum and pose.</summary>
        private (uint, PoseMessage) Ask(TimeSpan patience, CancellationToken stop)
        {
            foreach (var limit in Waits(patience))
            {
                // Each try has a new socket, as in lesson 02: a restarted publisher does not know of the request before.
                using var asker = new NetMQConnection(snapshots, () => new RequestSocket());
                if (!asker.TrySend(TimeSpan.Zero, stop, "pose/")) continue;
                if (!asker.TryReceive(limit, stop, out var frames)) continue;
                // One of several frames is no snapshot.
                var text = frames.Count == 1 ? frames[0] : "";
                var words = text.Split(' ', 2);
                var pose = PoseMessage.Parse(words[words.Length - 1]);
                if (pose != null && uint.TryParse(words[0], NumberStyles.None, CultureInfo.InvariantCulture, out var sum))
                    return (sum, pose);
                throw new TimeoutException($"what answers at {snapshots} gives no snapshots: {NetMQLifetime.Printable(text)}");
            }
            throw new TimeoutException(FormattableString.Invariant(
                $"no snapshot from {snapshots} within {patience.TotalSeconds} s; is the server running, or the line slow?"));
        }

        /// <summary>For a stream that is silent: where the port had been another program's, libzmq connects no more.</summary>
        private void Reconnect()
        {
            connection.Socket.Disconnect(endpoint);
            connection.Socket.Connect(endpoint);
        }

        /// <summary>How long to wait for each try: 1, 2, 4, 8, 8 … seconds. A new connection takes four round trips.</summary>
        private static IEnumerable<TimeSpan> Waits(TimeSpan patience)
        {
            var waited = Stopwatch.StartNew();
            var limit = Second;
            do
            {
                var left = patience - waited.Elapsed;
                yield return left > 2 * limit ? limit : left > TimeSpan.Zero ? left : TimeSpan.Zero;
                if (limit < 8 * Second) limit *= 2;
            }
            while (waited.Elapsed < patience);
        }

        /// <summary>Waits for a message. One of several frames is none of this lesson's: it counts as an empty one.</summary>
        private static bool Take(NetMQSocket socket, TimeSpan wait, CancellationToken stop, out byte[] frame)
        {
            foreach (var slice in NetMQConnection.Slices(wait, stop))
            {
                if (!socket.TryReceiveFrameBytes(slice, out frame, out var more)) continue;
                if (more) frame = Array.Empty<byte>();
                while (more) socket.SkipFrame(out more);
                return true;
            }
            frame = Array.Empty<byte>();
            return false;
        }
    }
}
