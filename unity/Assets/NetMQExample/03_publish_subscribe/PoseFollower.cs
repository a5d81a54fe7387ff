// Lesson 03 in Unity: a thread follows the publisher, and Update moves this object to the newest pose.
// The thread may take ten poses between two frames: whatever Update finds is the newest, and Unity never waits.
//
// Use: start python/03_publish_subscribe/server.py, add this component to a cube, press Play. Then stop the server,
// start it again, and read in the console what the cube has missed.
using System;
using System.Threading;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Moves its Transform as the publisher says.</summary>
    public sealed class PoseFollower : NetworkBehaviour
    {
        [SerializeField, Tooltip("The publisher")] private string endpoint = "tcp://127.0.0.1:5553";
        [SerializeField, Tooltip("Where it gives snapshots; empty: the port 100 higher")] private string snapshots = "";
        [SerializeField, Min(0), Tooltip("End after so many poses")] private int count = 300;
        [SerializeField, Min(0), Tooltip("Or at the pose of this number; 0: at none")] private int until = 0;
        [SerializeField, Min(0), Tooltip("Or after this time")] private float seconds = 60;
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait for the publisher")] private float patience = 5;
        [SerializeField, Min(0), Tooltip("Log one pose in so many; 0: none")] private int every = 60;
        [SerializeField, Min(0), Tooltip("Messages that may wait; 0: any number")] private int hwm = 1000;

        private volatile PoseMessage newest;

        /// <inheritdoc/>
        protected override void Update()
        {
            base.Update();
            if (newest != null) Move(newest);
        }

        /// <inheritdoc/>
        protected override void Talk(CancellationToken stop)
        {
            var time = System.Diagnostics.Stopwatch.StartNew();
            using var subscriber = new PoseSubscriber(endpoint, snapshots, Log, hwm);
            while (subscriber.Received < count && time.Elapsed.TotalSeconds < seconds)
            {
                var news = subscriber.Receive(Seconds(patience), stop);
                var pose = newest = subscriber.Pose;
                if (news && every > 0 && subscriber.Received % every == 0) InUpdate(() => Show(pose));
                if (until > 0 && pose.Number >= until) break;
            }
            Log(subscriber.Summary());
        }

        private void Show(PoseMessage pose)
        {
            Move(pose);
            var p = transform.position;
            Debug.Log(FormattableString.Invariant($"{pose.Number}: at {p.x:F4} {p.y:F4} {p.z:F4}"));
        }

        private void Move(PoseMessage pose) => transform.SetPositionAndRotation(
            new Vector3(pose.Position.X, pose.Position.Y, pose.Position.Z),
            new Quaternion(pose.Rotation.X, pose.Rotation.Y, pose.Rotation.Z, pose.Rotation.W));
    }
}
