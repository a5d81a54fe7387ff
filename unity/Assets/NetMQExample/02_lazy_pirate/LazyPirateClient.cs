// Lesson 02 in Unity: the lazy pirate asks on a thread of its own, and Update logs what it brings back.
//
// Use: start python/02_lazy_pirate/server.py, add this component to any GameObject, set Count to 100000, press Play. Then
// stop the server, see the retries in the console, and start it again: the count goes on where it was.
using System;
using System.Collections.Concurrent;
using System.Threading;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Adds to the server's account a number of times and logs each reply and each retry.</summary>
    public sealed class LazyPirateClient : MonoBehaviour
    {
        [SerializeField] private string endpoint = "tcp://127.0.0.1:5552";
        [SerializeField] private int count = 10;
        [SerializeField, Tooltip("add 1, or balance")] private string text = "add 1";
        [SerializeField, Tooltip("Seconds to wait, for the first try")] private float patience = 0.5f;
        [SerializeField, Tooltip("How often to send a request before giving up")] private int tries = 5;
        [SerializeField, Tooltip("Keep the socket for the next try")] private bool relaxed = false;

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
            thread = new Thread(Ask) { IsBackground = true, Name = nameof(LazyPirateClient) };
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
                using var pirate = new LazyPirateRequester(endpoint, TimeSpan.FromSeconds(patience), tries, Log, relaxed);
                for (var i = 1; i <= count; i++)
                {
                    var reply = NetMQLifetime.Printable(pirate.Request(text, cancelled));
                    Log($"{i}: sent {text}, received {reply}");
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
