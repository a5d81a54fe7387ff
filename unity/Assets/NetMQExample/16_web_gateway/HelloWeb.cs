// Lesson 16 in Unity: lesson 01's Hello through the gateway, also in a WebGL build. No thread: Update looks whether the
// reply is there.
//
// Use: start python/01_request_reply/server.py and python/16_web_gateway/server.py, add this component to any
// GameObject, press Play.
using System;
using UnityEngine;
using UnityEngine.Events;

namespace NetMQExample
{
    /// <summary>Says Hello to the server behind the gateway a number of times, and logs each reply.</summary>
    [AddComponentMenu("NetMQ Example/16 Hello Web")]
    public sealed class HelloWeb : MonoBehaviour
    {
        [SerializeField, Tooltip("The gateway")] private string endpoint = "http://127.0.0.1:5566";
        [SerializeField, Min(0), Tooltip("How many requests")] private int count = 10;
        [SerializeField, Tooltip("By Socket.IO in place of plain WebSocket")] private bool socketio = false;
        [SerializeField, Tooltip("The word that the gateway was given as --token")] private string token = "";
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait for each reply")] private float timeout = 2.5f;
        [SerializeField, Tooltip("Go on without the focus, as the whole game")] private bool runInBackground = true;
        [SerializeField, Tooltip("With each reply")] private UnityEvent<string> replied = new();

        private WebRequester requester;
        private int asked, replies;

        public event Action<string> Replied;

        /// <summary>True once the last line, or the reason why there is none, was logged.</summary>
        public bool Done => !enabled;

        private void OnEnable()
        {
            // Without it Unity stops calling Update when another window has the focus.
            if (runInBackground && !Application.runInBackground) Debug.Log("Application.runInBackground is now true");
            Application.runInBackground |= runInBackground;
            (requester, asked, replies) = (null, 0, 0);
            Debug.Log($"asking {endpoint}");
        }

        private void Update()
        {
            string[] frames = null;
            try
            {
                requester ??= WebRequester.To(endpoint, "hello", socketio, token, TimeSpan.FromSeconds(timeout));
                if (asked == replies && asked++ < count) requester.Ask("Hello");
                if (replies < count) requester.TryReceive(out frames);
            }
            catch (Exception e) when (e is TimeoutException || e is System.IO.IOException || e is ArgumentException)
            {
                Debug.LogError($"gave up: {e.Message}");
                enabled = false;
            }
            if (frames != null) Hear(string.Join(" ", frames));
            if (replies < count || !enabled) return;
            Debug.Log($"done: {replies} replies");
            enabled = false;
        }

        private void Hear(string reply)
        {
            Debug.Log($"{++replies}: sent Hello, received {WebText.Printable(reply)}");
            // Not by Arrival.cs, which a build for the browser does not have.
            replied.Invoke(reply);
            Replied?.Invoke(reply);
        }

        private void OnDisable() => requester?.Dispose();

        private void OnApplicationPause(bool paused)
        {
            // iOS and Android take the sockets of an app that is not seen; it begins again when it is back.
            if (!Application.isMobilePlatform || !isActiveAndEnabled) return;
            if (paused) OnDisable();
            else OnEnable();
        }
    }
}
