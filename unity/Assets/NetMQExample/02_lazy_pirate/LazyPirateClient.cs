// Lesson 02 in Unity: the lazy pirate asks on a thread of its own, and Update logs what it brings back.
//
// Use: start python/02_lazy_pirate/server.py, add this component to any GameObject, set Count to 100000, press Play.
// Then stop the server, see the retries in the console, and start it again: the count goes on where it was.
using System;
using System.Threading;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Adds to the server's account a number of times and logs each reply and each retry.</summary>
    [AddComponentMenu("NetMQ Example/02 Lazy Pirate Client")]
    public sealed class LazyPirateClient : NetworkBehaviour
    {
        [SerializeField, Tooltip("The server")] private string endpoint = "tcp://127.0.0.1:5552";
        [SerializeField, Min(0), Tooltip("How many requests")] private int count = 10;
        [SerializeField, Tooltip("add 1, or balance")] private string text = "add 1";
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait, for the first try")] private float timeout = 0.5f;
        [SerializeField, Min(1), Tooltip("How often to send a request before giving up")] private int tries = 5;
        [SerializeField, Tooltip("With each reply")] private Arrival<string> replied = new();

        public event Action<string> Replied { add => replied.Raised += value; remove => replied.Raised -= value; }

        protected override void Talk(CancellationToken stop)
        {
            Log($"asking {endpoint}");
            using var pirate = new LazyPirateRequester(endpoint, Seconds(timeout), tries, Log);
            for (var i = 1; i <= count; i++)
            {
                var reply = pirate.Request(text, stop);
                Log($"{i}: sent {text}, received {LogText.Printable(reply)}");
                Arrive(replied, reply);
            }
            Log($"done: {count} replies");
        }
    }
}
