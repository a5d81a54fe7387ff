// Lesson 16 in Unity: lesson 01's Hello through the gateway, also in a WebGL build. No thread: Update looks whether the
// reply is there.
//
// Use: start python/01_request_reply/server.py and python/16_web_gateway/server.py, add this component to any
// GameObject, press Play.
using System;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Says Hello to the server behind the gateway a number of times, and logs each reply.</summary>
    public sealed class HelloWeb : MonoBehaviour
    {
        [SerializeField, Tooltip("The gateway")] private string endpoint = "http://127.0.0.1:5566";
        [SerializeField, Min(0), Tooltip("How many requests")] private int count = 10;
        [SerializeField, Tooltip("By Socket.IO in place of plain WebSocket")] private bool socketio = false;
        [SerializeField, Tooltip("The word that the gateway was given as --token")] private string token = "";
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait for each reply")] private float patience = 2.5f;

        private WebRequester requester;
        private int replies;

        /// <summary>True once the last line, or the reason why there is none, was logged.</summary>
        public bool Done { get; private set; }

        private void OnEnable()
        {
            // Without it Unity stops calling Update when another window has the focus.
            Application.runInBackground = true;
            (replies, Done) = (0, false);
            Try(() =>
            {
                requester = WebRequester.To(endpoint, "hello", socketio, token, TimeSpan.FromSeconds(patience));
                Debug.Log($"asking {endpoint}");
                Ask();
            });
        }

        private void Update() => Try(() =>
        {
            if (Done || !requester.TryReceive(out var frames)) return;
            Debug.Log($"{++replies}: sent Hello, received {WebText.Printable(string.Join(" ", frames))}");
            Ask();
        });

        private void Ask()
        {
            Done = replies >= count;
            if (Done) Debug.Log($"done: {replies} replies");
            else requester.Ask("Hello");
        }

        private void Try(Action action)
        {
            try { action(); }
            catch (Exception e) when (e is TimeoutException || e is ArgumentException)
            {
                Done = true;
                Debug.LogError($"gave up: {e.Message}");
            }
        }

        private void OnDisable() => requester?.Dispose();

        private void OnApplicationPause(bool paused)
        {
            // iOS and Android take the sockets of an app that is not seen; it begins again when it is back.
            if (!Application.isMobilePlatform || Done) return;
            if (paused) OnDisable();
            else OnEnable();
        }
    }
}
