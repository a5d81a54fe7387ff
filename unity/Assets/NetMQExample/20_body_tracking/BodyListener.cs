// Application 20, the newest pose of one person or hand: how many were skipped for it, and how late it is.
//
// The Python side is python/20_body_tracking/server.py.
using System;
using System.Diagnostics;
using System.Threading;

namespace NetMQExample
{
    /// <summary>Listens to a person or hand over a SUB socket. Make it, use it and dispose it on one thread.</summary>
    public sealed class BodyListener : IDisposable
    {
        // MediaPipe's numbers.
        private static readonly (int, int, int) RightKnee = (24, 26, 28), IndexFinger = (5, 6, 7);
        private readonly TopicListener listener;
        private readonly Stopwatch clock = Stopwatch.StartNew();
        private readonly string endpoint;
        private double ahead = double.PositiveInfinity, behind;
        private long number;

        /// <summary>Subscribes and connects, which succeeds even while no server is there.</summary>
        /// <param name="endpoint">The server, such as <c>tcp://127.0.0.1:5570</c>.</param>
        /// <param name="person">Which one; they count from 0.</param>
        /// <param name="hand">left or right for a hand; empty for the person.</param>
        /// <exception cref="ArgumentException">One of them cannot work; the message names cause and cure.</exception>
        public BodyListener(string endpoint, int person = 0, string hand = "")
        {
            if (Require.Given("hand", hand) != "" && hand != "left" && hand != "right")
                throw new ArgumentException($"there is no hand '{LogText.Printable(hand)}': take left or right");
            this.endpoint = endpoint;
            Require.Count("person", person, least: 0);
            Topic = hand == "" ? FormattableString.Invariant($"pose/{person}/") : $"hand/{hand}/";
            Name = hand == "" ? FormattableString.Invariant($"person {person}") : $"{hand} hand";
            listener = new TopicListener(endpoint, Topic);
        }

        public string Topic { get; }

        /// <summary>The person or hand that it listens to, in words.</summary>
        public string Name { get; }

        /// <summary>How many poses were skipped, because a newer one was there.</summary>
        public long Skipped { get; private set; }

        /// <summary>True if the newest pose is the first one of a server that was started again.</summary>
        public bool Restarted { get; private set; }

        /// <summary>Waits for a pose, and so not on Unity's main thread.</summary>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        public BodyPose Receive(TimeSpan timeout, CancellationToken stop = default)
        {
            BodyPose pose;
            var end = clock.Elapsed + timeout;
            while ((pose = BodyPose.Parse(listener.Newest(timeout, stop))) == null)
                // However much of something else comes.
                if (clock.Elapsed >= end)
                    throw new TimeoutException(FormattableString.Invariant(
                        $"no pose from {endpoint} within {timeout.TotalSeconds} s; is that this server?"));
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

        /// <summary>One line about a pose that was just received.</summary>
        public string Line(BodyPose pose)
        {
            if (pose.Places == null) return $"{Name}: pose {pose.Number}, nobody is there";
            var body = pose.Visibility.Length == BodyPose.Landmarks;
            var (a, b, c) = body ? RightKnee : IndexFinger;
            return FormattableString.Invariant(
                $"{Name}: pose {pose.Number}, {(body ? "right knee" : "finger")} {pose.Angle(a, b, c):F0} degrees, ")
                + FormattableString.Invariant($"{1000 * behind:F0} ms late");
        }

        public override string ToString() => $"BodyListener {endpoint}";
        public void Dispose() => listener.Dispose();
    }
}
