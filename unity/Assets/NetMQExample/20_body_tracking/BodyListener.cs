// Application 20, the newest pose of one person: how many were skipped for it, and how late it is.
//
// Take home: this file and BodyPose.cs, with TopicListener.cs (lesson 03), NetMQConnection.cs and NetMQLifetime.cs. The
// Python side is python/20_body_tracking/server.py.
using System;
using System.Diagnostics;
using System.Threading;

namespace NetMQExample
{
    /// <summary>Listens to one person over a SUB socket. Make it, use it and dispose it on one thread.</summary>
    public sealed class BodyListener : IDisposable
    {
        // MediaPipe's numbers.
        private const int RightHip = 24, RightKnee = 26, RightAnkle = 28;
        private readonly TopicListener listener;
        private readonly Stopwatch clock = Stopwatch.StartNew();
        private readonly string endpoint;
        private readonly int person;
        private double ahead = double.PositiveInfinity, behind;
        private long number;

        /// <summary>Subscribes and connects, which succeeds even while no server is there.</summary>
        /// <param name="endpoint">The server, such as <c>tcp://127.0.0.1:5570</c>.</param>
        /// <param name="person">Which one; they count from 0.</param>
        /// <exception cref="ArgumentException">The endpoint cannot work; the message names cause and cure.</exception>
        public BodyListener(string endpoint, int person)
        {
            (this.endpoint, this.person) = (endpoint, person);
            listener = new TopicListener(endpoint, FormattableString.Invariant($"pose/{person}/"));
        }

        /// <summary>How many poses were skipped, because a newer one was there.</summary>
        public long Skipped { get; private set; }

        /// <summary>True if the newest pose is the first one of a server that was started again.</summary>
        public bool Restarted { get; private set; }

        /// <summary>Waits for a pose, and so not on Unity's main thread.</summary>
        /// <param name="patience">How long to wait.</param>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        /// <returns>The newest one.</returns>
        /// <exception cref="TimeoutException">None came.</exception>
        /// <exception cref="OperationCanceledException"><paramref name="stop"/> was cancelled.</exception>
        public BodyPose Receive(TimeSpan patience, CancellationToken stop = default)
        {
            BodyPose pose;
            var end = clock.Elapsed + patience;
            while ((pose = BodyPose.Parse(listener.Newest(patience, stop))) == null)
                // However much of something else comes.
                if (clock.Elapsed >= end)
                    throw new TimeoutException(FormattableString.Invariant(
                        $"no pose from {endpoint} within {patience.TotalSeconds} s; is that this server?"));
            // Numbers begin anew with each start of the server, and seconds where it is another computer's.
            Restarted = pose.Number < number;
            if (Restarted) ahead = double.PositiveInfinity;
            else if (number > 0) Skipped += Math.Max(0, pose.Number - number - 1);
            number = pose.Number;
            // The two clocks need not agree: a pose is late if it took longer than the quickest one.
            var travelled = clock.Elapsed.TotalSeconds - pose.Seconds;
            ahead = Math.Min(ahead, travelled);
            behind = travelled - ahead;
            return pose;
        }

        /// <summary>What is to be seen of a pose that was just received, in one line.</summary>
        public string Line(BodyPose pose) => $"person {person}: pose {pose.Number}, " + (pose.Places == null
            ? "nobody is there"
            : FormattableString.Invariant($"right knee {pose.Angle(RightHip, RightKnee, RightAnkle):F0} degrees, ")
                + FormattableString.Invariant($"{1000 * behind:F0} ms late"));

        /// <summary>Closes the socket, then leaves NetMQ.</summary>
        public void Dispose() => listener.Dispose();
    }
}
