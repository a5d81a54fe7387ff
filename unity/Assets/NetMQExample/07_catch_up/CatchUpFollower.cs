// Lesson 07 in Unity: a thread takes every pose, and Update moves this object to the newest one. So the cube is always
// where the publisher's is, and the thread still notices each pose that it missed.
//
// Use: start python/07_catch_up/server.py, add this component to a cube, press Play. Then stop the server, start it
// again, and read in the console what the cube has missed.
using System;
using System.Threading;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Moves its Transform as the publisher says.</summary>
    [AddComponentMenu("NetMQ Example/07 Catch Up Follower")]
    public sealed class CatchUpFollower : NetworkBehaviour
    {
        [SerializeField, Tooltip("The publisher")] private string endpoint = "tcp://127.0.0.1:5557";
        [SerializeField, Tooltip("Where it gives snapshots; empty: the port 100 higher")] private string snapshots = "";
        [SerializeField, Min(0), Tooltip("End after so many poses")] private int count = 300;
        [SerializeField, Min(0), Tooltip("Or at the pose of this number; 0: at none")] private int until = 0;
        [SerializeField, Min(0), Tooltip("Or after this time")] private float seconds = 60;
        [SerializeField, Min(0), Tooltip("Log one pose in so many; 0: none")] private int every = 60;
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait for a snapshot")] private float timeout = 5;
        [SerializeField, Tooltip("With each pose that a frame finds")] private Arrival<Pose> moved = new();

        private volatile PoseMessage newest;

        /// <summary>With each pose that a frame finds, for scripts: of several between two frames the newest.</summary>
        public event Action<Pose> Moved { add => moved.Raised += value; remove => moved.Raised -= value; }

        protected override void Update()
        {
            base.Update();
            if (!(Interlocked.Exchange(ref newest, null) is PoseMessage found)) return;
            var (p, r) = (found.Position, found.Rotation);
            var pose = new Pose(new Vector3(p.X, p.Y, p.Z), new Quaternion(r.X, r.Y, r.Z, r.W));
            transform.SetPositionAndRotation(pose.position, pose.rotation);
            moved.Raise(pose);
        }

        protected override void Talk(CancellationToken stop)
        {
            var time = System.Diagnostics.Stopwatch.StartNew();
            using var subscriber = new PoseSubscriber(endpoint, snapshots, Log);
            while (subscriber.Received < count && time.Elapsed.TotalSeconds < seconds)
            {
                if (!TryReceive(() => subscriber.Receive(Seconds(timeout), stop), out var news)) continue;
                var pose = subscriber.Pose;
                if (news) newest = pose;
                var p = pose.Position;
                if (news && every > 0 && subscriber.Received % every == 0)
                    Log(FormattableString.Invariant($"{pose.Number}: at {p.X:F4} {p.Y:F4} {p.Z:F4}"));
                if (until > 0 && pose.Number >= until) break;
            }
            Log($"done: received {subscriber.Received}, missed {subscriber.Missed}; "
                + $"run {subscriber.Pose.Run} at {subscriber.Pose.Number}, checksum {subscriber.Checksum}");
        }
    }
}
