// Lesson 15 in Unity: says hello to a server that knows this client by its key.
//
// Use: start python/15_security/server.py, add this component to any GameObject, press Play. The console asks for the
// server's public key. Copy server.key into the folder that it names, or write its 40 characters into the field, above
// all in a build. This client makes its own pair there at the first start; enrol its client.key.
using System;
using System.IO;
using System.Threading;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Says hello a number of times and logs each reply, or that this client is refused.</summary>
    [AddComponentMenu("NetMQ Example/15 Secure Hello")]
    public sealed class SecureHello : NetworkBehaviour
    {
        [SerializeField, Tooltip("The server")] private string endpoint = "tcp://127.0.0.1:5565";
        [SerializeField, Min(0), Tooltip("How many requests")] private int count = 10;
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait for each reply")] private float timeout = 1;
        [SerializeField, Min(1), Tooltip("How often to send a request before giving up")] private int tries = 3;
        [SerializeField, Tooltip("The folder of the keys, in persistentDataPath")] private string keys = "keys";
        [SerializeField, Tooltip("The server's public key; if empty, that in server.key")]
        private string serverKey = "";
        [SerializeField, Tooltip("With a new key, which nobody has enrolled")] private bool stranger;
        [SerializeField, Tooltip("Without keys")] private bool plain;
        [SerializeField, Tooltip("With each reply")] private Arrival<string> replied = new();

        public event Action<string> Replied { add => replied.Raised += value; remove => replied.Raised -= value; }

        protected override void Talk(CancellationToken stop)
        {
            // Unity tells it on the main thread only.
            var own = plain ? null : new ClientKeys(
                Path.Combine(FromUpdate(() => Application.persistentDataPath), keys), serverKey);
            Log($"asking {endpoint}");
            using var requester = new SecureRequester(
                endpoint, stranger ? own?.Stranger() : own, Seconds(timeout), tries, Log);
            for (var i = 1; i <= count; i++)
            {
                var reply = requester.Request("Hello", stop);
                Log($"{i}: sent Hello, received {LogText.Printable(reply)}");
                Arrive(replied, reply);
            }
            Log($"done: {count} replies");
        }
    }
}
