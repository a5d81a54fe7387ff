// Lesson 03 in Unity: a thread takes the newest pose, and Update moves this object there. Ten poses may come between
// two frames: Update always finds the newest, and Unity never waits.
//
// Use: start python/03_publish_subscribe/server.py, add this component to a cube, press Play.
using System.Globalization;
using System.Threading;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Moves its Transform as the publisher says.</summary>
    [AddComponentMenu("NetMQ Example/03 Pose Follower")]
    public sealed class PoseFollower : NetworkBehaviour
    {
        [SerializeField, Tooltip("Publisher, or beacon://NAME:5553")] private string endpoint = "tcp://127.0.0.1:5553";
        [SerializeField, Tooltip("How the messages begin")] private string topic = "pose/";
        [SerializeField, Min(0), Tooltip("End after so many poses; 0: never")] private int count = 300;
        [SerializeField, Min(0), Tooltip("Log one pose in so many; 0: none")] private int every = 60;
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait for each pose")] private float timeout = 5;
        [SerializeField, Tooltip("With each pose that a frame finds")] private Arrival<Pose> moved = new();

        private volatile float[] newest;

        /// <summary>With each pose that a frame finds, for scripts: of several between two frames the newest.</summary>
        public event System.Action<Pose> Moved { add => moved.Raised += value; remove => moved.Raised -= value; }

        protected override void Update()
        {
            base.Update();
            if (!(Interlocked.Exchange(ref newest, null) is float[] n)) return;
            var pose = new Pose(new Vector3(n[2], n[3], n[4]), new Quaternion(n[5], n[6], n[7], n[8]));
            transform.SetPositionAndRotation(pose.position, pose.rotation);
            moved.Raise(pose);
        }

        protected override void Talk(CancellationToken stop)
        {
            Log($"listening to '{topic}' from {endpoint}");
            using var listener = new TopicListener(endpoint, topic);
            for (var i = 0; count == 0 || i < count;)
            {
                // A publisher that is away ends nothing: the cube stands still until it is back.
                if (!TryReceive(() => listener.Newest(Seconds(timeout), stop), out var message)) continue;
                var pose = Parse(message);
                if (pose != null) newest = pose;
                var trouble = pose == null ? ": no pose, which has a number and 7 decimals" : "";
                if (every > 0 && i % every == 0) Log($"received {LogText.Printable(message)}{trouble}");
                i++;
            }
            Log($"done: received {count}");
        }

        // The words of `TOPIC NUMBER x y z qx qy qz qw`; null if these are others, since anybody can publish on a port.
        private static float[] Parse(string message)
        {
            var words = message.Split(' ');
            var n = new float[9];
            for (var i = 2; i < n.Length; i++)
                // Without the culture, a German machine reads 0.5 as 5.
                if (words.Length != n.Length
                    || !float.TryParse(words[i], NumberStyles.Float, CultureInfo.InvariantCulture, out n[i])
                    || !float.IsFinite(n[i])) return null;
            return n;
        }
    }
}
