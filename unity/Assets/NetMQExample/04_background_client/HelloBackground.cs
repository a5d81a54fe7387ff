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
    [DisallowMultipleComponent]
    public sealed class HelloBackground : MonoBehaviour
    {
        [SerializeField, Tooltip("The server")] private string endpoint = "tcp://127.0.0.1:5554";
        [SerializeField, Min(0), Tooltip("How many requests")] private int count = 10;
        [SerializeField, Tooltip("hello, or echo TEXT")] private string text = "hello";
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait for each reply")] private float patience = 1;
        [SerializeField, Min(1), Tooltip("How often to send a request before giving up")] private int tries = 20;
        [SerializeField, Tooltip("Go on while another window has the focus; this is a setting of the whole game")]
        private bool runInBackground = true;

        // Made once: written at the call, they would be new objects in each frame.
        private Action<string> onReply, onError;
        private string shown;
        private int asked, replies, frames;
        private float longest;

        /// <summary>For those who want to know how it goes, such as HelloWorldHud.</summary>
        public BackgroundClient Client { get; private set; }

        /// <summary>True once the last reply, or the reason why there is none, was logged.</summary>
        public bool Done { get; private set; }

        private void OnEnable()
        {
            if (runInBackground && !Application.runInBackground)
            {
                // Without it Unity stops calling Update when another window has the focus.
                Application.runInBackground = true;
                Debug.Log("Application.runInBackground is now true");
            }
            (onReply, onError, shown, Done) = (OnReply, OnError, "", false);
            (asked, replies, frames, longest) = (0, 0, 0, 0);
            Connect();
            if (Client != null) Debug.Log($"asking {endpoint}");
        }

        private void Update()
        {
            if (Done) return;
            // Time.deltaTime never says more than Time.maximumDeltaTime, a third of a second.
            if (frames++ > 0) longest = Math.Max(longest, Time.unscaledDeltaTime);
            Client.Poll();
            if (asked < count && Client.Request(text, onReply, onError)) asked++;
            ShowTrouble();
            if (replies >= count) Finish();
        }

        private void OnDisable()
        {
            // What is still under way ends with OnError, before Dispose returns.
            Done = true;
            Client?.Dispose();
        }

        // iOS and Android take the sockets of an app that is not seen. What was under way then is asked again.
        private void OnApplicationPause(bool paused)
        {
            if (!Application.isMobilePlatform || Done || Client == null) return;
            if (paused) Client.Dispose();
            else if (Client.State == ClientState.Disposed) Connect();
        }

        private void Connect()
        {
            Client = null;
            try
            {
                if (!(patience > 0 && patience <= 86400)) throw new ArgumentException($"patience must be more than 0 s and at most a day, not {patience}");
                Client = new BackgroundClient(endpoint, TimeSpan.FromSeconds(patience), tries);
            }
            catch (ArgumentException e)
            {
                // Said once: without a client Update has nothing to do.
                Done = true;
                Debug.LogError($"gave up: {e.Message}");
            }
        }

        private void OnReply(string reply)
        {
            replies++;
            ShowTrouble();
            Debug.Log($"{replies}: sent {text}, received {NetMQLifetime.Printable(reply)}");
        }

        private void OnError(string why)
        {
            if (Client.State == ClientState.Disposed) asked--;
            else if (!Done) Finish(why);
        }

        private void ShowTrouble()
        {
            var (state, error) = Client.Status;
            if (error != shown && state != ClientState.Lost) Debug.Log($"trouble: {shown = error}");
        }

        private void Finish(string why = null)
        {
            Done = true;
            Debug.Log(FormattableString.Invariant($"frames: {frames}, the longest took {longest * 1000:F0} ms"));
            if (why != null) Debug.LogError($"gave up: {why}");
            else Debug.Log($"done: {replies} replies");
        }
    }
}
