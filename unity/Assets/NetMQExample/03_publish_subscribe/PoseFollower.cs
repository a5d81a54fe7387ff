// Lesson 03 in Unity: a thread follows the publisher, and Update moves this object to the newest pose.
// The thread may take ten poses between two frames: whatever Update finds is the newest, and Unity never waits.
//
// Use: start python/03_publish_subscribe/server.py, add this component to a cube, press Play. Then stop the server,
// start it again, and read in the console what the cube has missed.
using System;
using System.Collections.Concurrent;
using System.Diagnostics;
using System.Threading;
using UnityEngine;
using Debug = UnityEngine.Debug;

namespace NetMQExample
{
    /// <summary>Moves its Transform as the publisher says.</summary>
    public sealed class PoseFollower : MonoBehaviour
    {
        [SerializeField] private string endpoint = "tcp://127.0.0.1:5553";
        [SerializeField, Tooltip("Where the publisher gives snapshots; empty: the port 100 higher")] private string snapshots = "";
        [SerializeField, Tooltip("End after so many poses")] private int count = 300;
        [SerializeField, Tooltip("Or at the pose of this number; 0: at none")] private int until = 0;
        [SerializeField, Tooltip("Or after this time")] private float seconds = 60;
        [SerializeField, Tooltip("Seconds to wait for the publisher")] private float patience = 5;
        [SerializeField, Tooltip("Log one pose in so many; 0: none")] private int every = 60;
        [SerializeField, Tooltip("Messages that may wait; 0: any number")] private int hwm = 1000;

        private readonly ConcurrentQueue<Action> forUpdate = new ConcurrentQueue<Action>();
        private volatile PoseMessage newest;
        private CancellationTokenSource stop;
        private Thread thread;

        /// <summary>True once the last line, or the reason why there is none, was logged.</summary>
        public bool Done => !thread.IsAlive && forUpdate.IsEmpty;

        private void OnEnable()
        {
            // Without it Unity stops calling Update when another window has the focus.
            Application.runInBackground = true;
            stop = new CancellationTokenSource();
            thread = new Thread(Follow) { IsBackground = true, Name = nameof(PoseFollower) };
            thread.Start(stop.Token);
        }

        private void Update()
        {
            while (forUpdate.TryDequeue(out var action)) action();
            if (newest != null) Move(newest);
        }

        // Unity tells all objects before it disables the first: on Stop ten clients then end in the time of one.
        private void OnApplicationQuit() => stop?.Cancel();

        private void OnDisable()
        {
            stop.Cancel();
            // It ends within 50 ms, and is never waited for longer than 200: Stop must not freeze the editor.
            NetMQLifetime.Join(thread);
        }

        private void Follow(object token)
        {
            var cancelled = (CancellationToken)token;
            var time = Stopwatch.StartNew();
            try
            {
                using var subscriber = new PoseSubscriber(endpoint, snapshots, Log, hwm);
                while (subscriber.Received < count && time.Elapsed.TotalSeconds < seconds)
                {
                    var news = subscriber.Receive(TimeSpan.FromSeconds(patience), cancelled);
                    newest = subscriber.Pose;
                    if (news && every > 0 && subscriber.Received % every == 0) Show(newest);
                    if (until > 0 && newest.Number >= until) break;
                }
                Log(subscriber.Summary());
            }
            catch (OperationCanceledException) { /* Stop was pressed. */ }
            catch (Exception e)
            {
                forUpdate.Enqueue(() => Debug.LogError($"gave up: {NetMQLifetime.Why(e)}"));
            }
        }

        private void Show(PoseMessage pose) => forUpdate.Enqueue(() =>
        {
            Move(pose);
            var p = transform.position;
            Debug.Log(FormattableString.Invariant($"{pose.Number}: at {p.x:F4} {p.y:F4} {p.z:F4}"));
        });

        private void Move(PoseMessage pose)
        {
            transform.position = new Vector3(pose.Position.X, pose.Position.Y, pose.Position.Z);
            transform.rotation = new Quaternion(pose.Rotation.X, pose.Rotation.Y, pose.Rotation.Z, pose.Rotation.W);
        }

        private void Log(string line) => forUpdate.Enqueue(() => Debug.Log(line));
    }
}
