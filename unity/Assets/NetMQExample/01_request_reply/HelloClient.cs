// Lesson 01 in Unity: the questions are asked on a thread of their own, so that Unity never waits for the network.
// That thread, and how its lines get to Update, is in NetworkBehaviour.cs (Shared).
//
// Use: start python/01_request_reply/server.py, add this component to any GameObject, press Play.
using System;
using System.Threading;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Says Hello to the server a number of times and logs each reply.</summary>
    [AddComponentMenu("NetMQ Example/01 Hello Client")]
    public sealed class HelloClient : NetworkBehaviour
    {
        [SerializeField, Tooltip("The server")] private string endpoint = "tcp://127.0.0.1:5551";
        [SerializeField, Min(0), Tooltip("How many requests")] private int count = 10;
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait for each reply")] private float timeout = 2.5f;
        [SerializeField, Tooltip("With each reply")] private Arrival<string> replied = new();

        public event Action<string> Replied { add => replied.Raised += value; remove => replied.Raised -= value; }

        protected override void Talk(CancellationToken stop)
        {
            Log($"asking {endpoint}");
            using var requester = new HelloRequester(endpoint);
            for (var i = 1; i <= count; i++)
            {
                var reply = requester.Request("Hello", Seconds(timeout), stop);
                Log($"{i}: sent Hello, received {LogText.Printable(reply)}");
                Arrive(replied, reply);
            }
            Log($"done: {count} replies");
        }
    }
}
