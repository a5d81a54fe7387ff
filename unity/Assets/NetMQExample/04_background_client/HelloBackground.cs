// Lesson 04 in Unity: once a frame a request, and the callbacks of what came back. No thread, no lock, no waiting here.
//
// Use: start python/04_background_client/server.py, add this component and HelloWorldHud to a GameObject, press Play.
// Set Count to 100000, stop the server while it runs and start it again: the game goes on, and so do the replies.
// The Python and terminal clients print the same lines.
using System;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Says hello to the server, once a frame, a number of times, and logs each reply.</summary>
    [AddComponentMenu("NetMQ Example/04 Hello Background")]
    [DisallowMultipleComponent]
    public sealed class HelloBackground : ConnectedBehaviour
    {
        [SerializeField, Tooltip("The server, or beacon://NAME:5554")] private string endpoint = "tcp://127.0.0.1:5554";
        [SerializeField, Min(0), Tooltip("How many requests")] private int count = 10;
        [SerializeField, Tooltip("hello, or echo TEXT")] private string text = "hello";
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait for each reply")] private float timeout = 1;
        [SerializeField, Min(1), Tooltip("How often to send a request before giving up")] private int tries = 20;
        [SerializeField, Tooltip("With each reply")] private Arrival<string> replied = new();

        private string shown;
        private int asked, replies;
        private bool done;

        public event Action<string> Replied { add => replied.Raised += value; remove => replied.Raised -= value; }

        /// <summary>For those who want to know how it goes, such as HelloWorldHud.</summary>
        public BackgroundClient Client { get; private set; }

        public override bool Done => done || !enabled;

        public override string State => Client == null || !enabled ? base.State : FormattableString.Invariant(
            $"{Client.State}, round trip {Client.RoundTripTime.TotalMilliseconds:F1} ms");

        protected override void Begin()
        {
            asked = 0;
            replies = 0;
            shown = "";
            done = false;
            Client = new BackgroundClient(endpoint, Seconds(timeout), tries);
            Debug.Log($"asking {endpoint}");
        }

        protected override void End() => Client?.Dispose();

        private void Update()
        {
            if (done) return;
            var (state, error) = Client.Status;
            if (error != shown && state != ClientState.Lost)
            {
                Debug.Log($"trouble: {error}");
                shown = error;
            }
            Client.Poll();
            if (asked < count && Client.Request(text, OnReply, Finish)) asked++;
            if (replies >= count) Finish(null);
        }

        private void OnReply(string reply)
        {
            // Dispose hands out what has come, and a component that is disabled hears no more.
            if (Client.State == ClientState.Disposed) return;
            Debug.Log($"{++replies}: sent {text}, received {LogText.Printable(reply)}");
            replied.Raise(reply);
        }

        private void Finish(string why)
        {
            // Dispose ends what is under way with the error callback: that is no reason to give up.
            if (done || Client.State == ClientState.Disposed) return;
            done = true;
            if (why != null) GiveUp(why);
            else Debug.Log($"done: {replies} replies");
        }
    }
}
