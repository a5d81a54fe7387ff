// Lesson 06 in Unity: many requests under way on a thread of their own, and their replies in Update.
//
// Use: start python/06_many_in_flight/server.py, add this component to any GameObject, press Play.
using System;
using System.Collections.Concurrent;
using System.Linq;
using System.Threading;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Asks the server a number of things at once and logs each reply when it arrives.</summary>
    public sealed class ManyClient : MonoBehaviour
    {
        [SerializeField] private string endpoint = "tcp://127.0.0.1:5556";
        [SerializeField, Tooltip("How many requests")] private int count = 6;
        [SerializeField, Tooltip("Requests to repeat, with | between")] private string text = "sleep 0.8|echo one|sleep 0.5|echo two|sleep 0.2|echo three";
        [SerializeField, Tooltip("How many requests may be under way")] private int window = 4;
        [SerializeField, Tooltip("Seconds to wait for each reply")] private float patience = 2.5f;
        [SerializeField, Tooltip("How often to send a request before giving up")] private int tries = 3;

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
            thread = new Thread(Ask) { IsBackground = true, Name = nameof(ManyClient) };
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
            try
            {
                Log($"asking {endpoint}, {window} in flight");
                using var requester = new ManyRequester(endpoint, window, TimeSpan.FromSeconds(patience), tries, Log);
                var (texts, failures) = (text.Split('|'), 0);
                var requests = Enumerable.Range(0, count).Select(i => texts[i % texts.Length]);
                foreach (var answer in requester.RequestMany(requests, (CancellationToken)token))
                {
                    if (answer.Failure != null) failures++;
                    var outcome = answer.Failure == null ? $"received {answer.Reply}" : $"gave up: {answer.Failure}";
                    Log($"{answer.Number}: sent {texts[(answer.Number - 1) % texts.Length]}, {outcome}");
                }
                Log($"done: {count - failures} replies");
                if (failures > 0) throw new TimeoutException($"{failures} of {count} requests to {endpoint} have no reply; see above");
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
