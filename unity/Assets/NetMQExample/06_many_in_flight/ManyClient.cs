// Lesson 06 in Unity: many requests under way on a thread of their own, and their replies in Update.
//
// Use: start python/06_many_in_flight/server.py, add this component to any GameObject, press Play.
using System;
using System.Linq;
using System.Threading;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Asks the server a number of things at once and logs each reply when it arrives.</summary>
    [AddComponentMenu("NetMQ Example/06 Many Client")]
    public sealed class ManyClient : NetworkBehaviour
    {
        [SerializeField, Tooltip("The server")] private string endpoint = "tcp://127.0.0.1:5556";
        [SerializeField, Min(0), Tooltip("How many requests")] private int count = 6;
        [SerializeField, Tooltip("Requests to repeat, with | between")]
        private string text = "sleep 0.8|echo one|sleep 0.5|echo two|sleep 0.2|echo three";
        [SerializeField, Min(1), Tooltip("How many requests may be under way")] private int window = 4;
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait, for the first try")] private float timeout = 2.5f;
        [SerializeField, Min(1), Tooltip("How often to send a request before giving up")] private int tries = 3;
        [SerializeField, Tooltip("With each reply, in the order in which they come")]
        private Arrival<string> replied = new();

        public event Action<string> Replied { add => replied.Raised += value; remove => replied.Raised -= value; }

        protected override void Talk(CancellationToken stop)
        {
            Log($"asking {endpoint}, {window} in flight");
            using var requester = new ManyRequester(endpoint, window, Seconds(timeout), tries, Log);
            var texts = text.Split('|');
            var failures = 0;
            var requests = Enumerable.Range(0, count).Select(i => texts[i % texts.Length]);
            foreach (var answer in requester.RequestMany(requests, stop))
            {
                if (answer.Failure != null) failures++;
                var outcome = answer.Failure == null
                    ? $"received {LogText.Printable(answer.Reply)}"
                    : $"gave up: {answer.Failure}";
                var asked = LogText.Printable(texts[(answer.Number - 1) % texts.Length]);
                Log($"{answer.Number}: sent {asked}, {outcome}");
                if (answer.Failure == null) Arrive(replied, answer.Reply);
            }
            Log($"done: {count - failures} replies");
            var where = $"{count} requests to {endpoint}";
            if (failures > 0) throw new TimeoutException($"{failures} of {where} have no reply; see above");
        }
    }
}
