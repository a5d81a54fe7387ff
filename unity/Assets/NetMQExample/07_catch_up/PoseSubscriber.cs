// Lesson 07, catch up: follow a stream, notice each missed message, and get back to the exact state.
//
// The Python side is python/07_catch_up/server.py, whose header says the bytes: UTF-8 text, one frame, numbers with a
// decimal point.
// One rule: a pose that is not the next one calls for a snapshot. It cures joining late, loss and a restart alike.
// Trouble: start the server with --interval 0 and a client with --work 0.001, or restart the server.
using System;
using System.Diagnostics;
using System.Globalization;
using System.Numerics;
using System.Text.RegularExpressions;
using System.Threading;
using NetMQ.Sockets;

namespace NetMQExample
{
    /// <summary>The pose of one message: its run, its number, and a place in Unity's metres and axes.</summary>
    public sealed class PoseMessage
    {
        // Plain digits, as Python reads them.
        private const string Shape = @"^pose/ [0-9a-z]{1,32} [0-9]{1,18}( -?[0-9]{1,20}(\.[0-9]{1,20})?){7}\z";

        private PoseMessage(string[] words)
        {
            // Without the culture, a German machine reads 0.5 as 5.
            float At(int i) => float.Parse(words[i], CultureInfo.InvariantCulture);
            Run = words[1];
            Number = long.Parse(words[2], CultureInfo.InvariantCulture);
            Position = new Vector3(At(3), At(4), At(5));
            Rotation = new Quaternion(At(6), At(7), At(8), At(9));
        }

        /// <summary>Before the first: no run has its name, so that every other pose is not the next one.</summary>
        public static PoseMessage None { get; } = new PoseMessage("pose/  0 0 0 0 0 0 0 1".Split(' '));

        /// <summary>Another one with each start of the publisher, whose numbers begin anew then.</summary>
        public string Run { get; }

        /// <summary>Counts the poses of a run, from 1.</summary>
        public long Number { get; }

        public Vector3 Position { get; }
        public Quaternion Rotation { get; }

        /// <summary>Reads a message; null if it is no pose, since anybody can publish on a port.</summary>
        public static PoseMessage Parse(string message) =>
            Regex.IsMatch(message, Shape) ? new PoseMessage(message.Split(' ')) : null;
    }

    /// <summary>Follows the publisher over a SUB socket. Make it, use it and dispose it on one thread, and not on
    /// Unity's main thread: to receive is to wait.</summary>
    public sealed class PoseSubscriber : IDisposable
    {
        private static readonly TimeSpan Second = TimeSpan.FromSeconds(1);

        private readonly NetMQConnection stream;
        private readonly string endpoint;
        private readonly string snapshots;
        private readonly Action<string> report;
        // How many snapshots in a row came though the stream was silent.
        private int withoutStream;

        /// <summary>Subscribes and connects, which succeeds even while no publisher is there.</summary>
        /// <param name="endpoint">The publisher, such as <c>tcp://127.0.0.1:5557</c>.</param>
        /// <param name="snapshots">Where it gives snapshots; null or empty for the port 100 higher.</param>
        /// <param name="report">Called, on the thread that receives, with a line about what was missed, unless it is
        /// null.</param>
        /// <exception cref="ArgumentException">The endpoint cannot work; the message names cause and cure.</exception>
        public PoseSubscriber(string endpoint, string snapshots = null, Action<string> report = null)
        {
            NetMQConnection.Host(endpoint);
            var higher = Regex.Replace(endpoint, "[0-9]+$", port => $"{int.Parse(port.Value) + 100}");
            this.endpoint = endpoint;
            this.snapshots = string.IsNullOrEmpty(snapshots) ? higher : snapshots;
            NetMQConnection.Host(this.snapshots);
            this.report = report ?? (line => { });
            stream = new NetMQConnection(endpoint, () =>
            {
                var socket = new SubscriberSocket();
                socket.Subscribe("pose/");
                return socket;
            });
            this.report($"following {endpoint}, snapshots from {this.snapshots}");
        }

        public PoseMessage Pose { get; private set; } = PoseMessage.None;

        /// <summary>The publisher's checksum right after it sent <see cref="Pose"/>.</summary>
        public uint Checksum { get; private set; }

        /// <summary>How many poses came over the stream.</summary>
        public long Received { get; private set; }

        /// <summary>How many poses did not, and were made up for by a snapshot.</summary>
        public long Missed { get; private set; }

        /// <summary>Waits for the next pose.</summary>
        /// <param name="timeout">How long to wait for a snapshot, if one is needed.</param>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        /// <returns>False if there is none yet.</returns>
        /// <exception cref="TimeoutException">The publisher is gone.</exception>
        /// <exception cref="GaveUpException">The peer that gives snapshots is no publisher of poses.</exception>
        /// <exception cref="OperationCanceledException"><paramref name="stop"/> was cancelled.</exception>
        public bool Receive(TimeSpan timeout, CancellationToken stop = default)
        {
            for (var waited = Stopwatch.StartNew(); waited.Elapsed < Second;)
            {
                // The lost pose may have been the last one. So a second of silence calls for a snapshot as well.
                var message = Take(stream, Second, stop);
                var pose = PoseMessage.Parse(message ?? "");
                if (pose == null || pose.Run != Pose.Run || pose.Number > Pose.Number + 1)
                    return CatchUp(timeout, message == null, stop);
                // A lower number was sent before the snapshot was made, and is contained in it.
                if (pose.Number != Pose.Number + 1) continue;
                Pose = pose;
                withoutStream = 0;
                Checksum *= 31;
                foreach (var character in message) Checksum += character;
                Received++;
                return true;
            }
            // A publisher that repeats itself must not hold the caller for ever.
            return false;
        }

        public override string ToString() => $"PoseSubscriber {endpoint}";
        public void Dispose() => stream.Dispose();

        /// <summary>Takes over the publisher's state from a snapshot, and says which poses that skips.</summary>
        private bool CatchUp(TimeSpan timeout, bool silent, CancellationToken stop)
        {
            var old = Pose;
            (Checksum, Pose) = Ask(timeout, stop);
            var first = old == PoseMessage.None;
            var same = Pose.Run == old.Run;
            if (same && Pose.Number <= old.Number) return false;
            if (!first) Missed += same ? Pose.Number - old.Number : Pose.Number;
            report(first ? $"joined run {Pose.Run} at {Pose.Number}, checksum {Checksum}"
                : same ? $"missed {old.Number + 1} to {Pose.Number}"
                : $"missed run {old.Run} from {old.Number + 1} on, and run {Pose.Run} up to {Pose.Number}");
            // The publisher goes on and nothing comes: where another program had the port, libzmq connects no more.
            if (!silent || stream.Socket.HasIn) return true;
            withoutStream++;
            if (withoutStream > 5)
                throw new TimeoutException($"no pose came over {endpoint}; is that the publisher, and its port open?");
            stream.Close();
            return true;
        }

        /// <summary>A snapshot from the publisher: checksum and pose.</summary>
        private (uint, PoseMessage) Ask(TimeSpan timeout, CancellationToken stop)
        {
            var waited = Stopwatch.StartNew();
            var left = timeout;
            for (var limit = Second; left > TimeSpan.Zero; limit *= 4, left = timeout - waited.Elapsed)
            {
                // Each try has a new socket, as in lesson 02, and more time: a new connection takes four round trips.
                using var asker = new NetMQConnection(snapshots, () => new RequestSocket());
                var wait = limit < left ? limit : left;
                // To a beacon that nobody answers yet nothing can be sent.
                if (!asker.TrySend(wait, stop, "pose/")) continue;
                if (!(Take(asker, wait, stop) is string text)) continue;
                var words = text.Split(' ', 2);
                var pose = PoseMessage.Parse(words[words.Length - 1]);
                if (pose != null && uint.TryParse(words[0], NumberStyles.None, CultureInfo.InvariantCulture, out var n))
                    return (n, pose);
                throw new GaveUpException(
                    $"what answers at {snapshots} gives no snapshots: {LogText.Printable(text)}; "
                    + "is that lesson 07's second port?");
            }
            throw new TimeoutException(FormattableString.Invariant(
                $"no snapshot from {snapshots} within {timeout.TotalSeconds} s; is the server running?"));
        }

        /// <summary>The next message, or null. One of several frames is not this lesson's, and as if empty.</summary>
        private static string Take(NetMQConnection from, TimeSpan timeout, CancellationToken stop) =>
            !from.TryReceive(timeout, stop, out var frames) ? null : frames.Count == 1 ? frames[0] : "";
    }
}
