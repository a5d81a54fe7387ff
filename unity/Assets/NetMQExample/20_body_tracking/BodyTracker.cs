// Application 20 in Unity: a thread takes the newest pose of a person, and Update smooths it. PoseSkeleton and
// PoseAvatar show it.
//
// Use: start python/20_body_tracking/server.py, add this component and one of those to an object, press Play. A second
// person is a second object.
using System;
using System.Threading;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Where the landmarks of a person or a hand are.</summary>
    [AddComponentMenu("NetMQ Example/20 Body Tracker")]
    public sealed class BodyTracker : NetworkBehaviour
    {
        [SerializeField, Tooltip("The server, or beacon://NAME:5570")] private string endpoint = "tcp://127.0.0.1:5570";
        [SerializeField, Min(0), Tooltip("Which person; they count from 0")] private int person;
        [SerializeField, Tooltip("left or right: a hand, and no person")] private string hand = "";
        [SerializeField, Min(0), Tooltip("End after so many poses; 0: never")] private int count;
        [SerializeField, Min(0), Tooltip("Log one pose in so many; 0: none")] private int every = 25;
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait for each pose")] private float timeout = 5;
        [SerializeField, Tooltip("With each pose that a frame finds")] private Arrival<BodyPose> tracked = new();

        private OneEuroFilter filter;
        private volatile BodyPose newest;
        private BodyPose shown;

        /// <summary>With each pose that a frame finds, for scripts; without places while nobody is there.</summary>
        public event Action<BodyPose> Tracked { add => tracked.Raised += value; remove => tracked.Raised -= value; }

        /// <summary>False before the first pose, and while nobody is there.</summary>
        public bool Present => filter != null && newest?.Places != null;

        public bool IsHand => hand != "";

        /// <summary>Where a landmark is, from the middle of the hips or of the hand, in Unity's axes.</summary>
        public Vector3 Place(int landmark)
        {
            if (filter == null) return Vector3.zero;
            var values = filter.Values;
            var x = 3 * landmark;
            return new Vector3((float)values[x], (float)values[x + 1], (float)values[x + 2]);
        }

        protected override void Update()
        {
            base.Update();
            var pose = newest;
            if (pose?.Places is double[] places)
                (filter ??= new OneEuroFilter(places.Length)).Step(places, Time.deltaTime);
            if (pose == shown) return;
            shown = pose;
            tracked.Raise(pose);
        }

        protected override void Talk(CancellationToken stop)
        {
            using var listener = new BodyListener(endpoint, person, hand);
            Log($"listening to '{listener.Topic}' from {endpoint}");
            for (var i = 0; i < count || count == 0;)
            {
                // The body stands still meanwhile.
                if (!TryReceive(() => listener.Receive(Seconds(timeout), stop), out var pose)) continue;
                newest = pose;
                if (listener.Restarted) Log($"{listener.Name}: the server was started again");
                if (every > 0 && i % every == 0) Log(listener.Line(pose));
                i++;
            }
            Log($"done: {count} poses, {listener.Skipped} skipped");
        }
    }
}
