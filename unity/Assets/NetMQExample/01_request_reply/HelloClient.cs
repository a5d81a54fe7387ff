// Lesson 01 in Unity: the questions are asked on a thread of their own, so that Unity never waits for the network.
// What they bring back goes through a queue that Update empties: only the main thread may touch the scene.
//
// Use: start python/01_request_reply/server.py, add this component to any GameObject, press Play.
using System;
using System.Collections.Concurrent;
using System.Threading;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Says Hello to the server a number of times and logs each reply.</summary>
    public sealed class HelloClient : MonoBehaviour
    {
        [SerializeField] private string endpoint = "tcp://127.0.0.1:5551";
        [SerializeField] private int count = 10;
        [SerializeField, Tooltip("Seconds to wait for each reply")] private float patience = 2.5f;

        private readonly ConcurrentQueue<Action> forUpdate = new ConcurrentQueue<Action>();
        private CancellationTokenSource stop;
        private Thread thread;

        /// <summary>True once the last reply, or the reason why there is none, was logged.</summary>
        public bool Done => !thread.IsAlive && forUpdate.IsEmpty;

        private void OnEnable()
        {
            // Without it Unity stops calling Update when another window has the focus.
            Application.runInBackground = true;
            stop = new CancellationTokenSource();
            thread = new Thread(Ask) { IsBackground = true, Name = nameof(HelloClient) };
            thread.Start(stop.Token);
        }

        private void Update()
        {
            while (forUpdate.TryDequeue(out var action)) action();
        }

        // Unity tells all objects before it disables the first: on Stop ten clients then end in the time of one.
        private void OnApplicationQuit() => stop?.Cancel();

        private void OnDisable()
        {
            stop.Cancel();
            // It ends within 50 ms, and is never waited for longer than 200: Stop must not freeze the editor.
            NetMQLifetime.Join(thread);
        }

        private void Ask(object token)
        {
            var cancelled = (CancellationToken)token;
            try
            {
                Log($"asking {endpoint}");
                using var requester = new HelloRequester(endpoint);
                for (var i = 1; i <= count; i++)
                {
                    var reply = NetMQLifetime.Printable(
                        requester.Request("Hello", TimeSpan.FromSeconds(patience), cancelled));
                    Log($"{i}: sent Hello, received {reply}");
                }
                Log($"done: {count} replies");
            }
            catch (OperationCanceledException) { /* Stop was pressed. */ }
            catch (Exception e)
            {
                forUpdate.Enqueue(() => Debug.LogError($"gave up: {NetMQLifetime.Why(e)}"));
            }
        }

        private void Log(string line) => forUpdate.Enqueue(() => Debug.Log(line));
    }
}
