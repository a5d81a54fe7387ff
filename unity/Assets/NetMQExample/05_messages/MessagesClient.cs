// Lesson 05 in Unity: pictures go to Python from a thread of their own, and Update logs what comes back.
//
// Use: start python/05_messages/server.py, add this component to any GameObject, press Play.
// A picture is taken only when the last one was answered, so no old one ever waits in a queue: the newest wins. For
// your camera, fill the texture with ReadPixels, or take the bytes from AsyncGPUReadback, which does not block
// Unity.
using System;
using System.Threading;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Sends pictures to the server a number of times and logs where each is brightest.</summary>
    public sealed class MessagesClient : NetworkBehaviour
    {
        [SerializeField, Tooltip("The server")] private string endpoint = "tcp://127.0.0.1:5555";
        [SerializeField, Min(0), Tooltip("How many pictures")] private int count = 10;
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait for each reply")] private float patience = 2.5f;
        [SerializeField, Min(1), Tooltip("Pictures in a row that may stay without a reply")] private int tries = 20;
        [SerializeField, Min(0), Tooltip("The camera's pictures a second; 0: one for each reply")] private int fps;
        [SerializeField, Tooltip("Send JPEG instead of raw bytes")] private bool jpeg;

        // One buffer for all pictures: Update fills it while the network thread waits, and never else.
        private readonly byte[] pixels = new byte[TestCamera.Size];
        private Texture2D texture;

        private void Awake() =>
            texture = new Texture2D(TestCamera.Width, TestCamera.Height, TextureFormat.RGB24, false);

        /// <inheritdoc/>
        protected override void Talk(CancellationToken stop)
        {
            Log($"asking {endpoint}");
            var view = new TestCamera(fps);
            // Pictures are large: their buffers are used again, by all NetMQ sockets of this game. For smaller messages
            // a MessageRequester will do.
            PooledBuffers.Use();
            using var requester = new PooledRequester(endpoint);
            for (int i = 1, lost = 0; i <= count;)
            {
                var request = FromUpdate(() => view.Look() ? Take(view.Number) : null);
                // The camera has no newer picture yet: look again in the next frame.
                if (request == null) continue;
                try
                {
                    Log(TestCamera.Describe(i, request, requester.Request(request, Seconds(patience), stop)));
                    (i, lost) = (i + 1, 0);
                }
                catch (TimeoutException e) when (++lost < tries)
                {
                    // This picture is not sent again: by now there is a newer one.
                    Log($"trouble: {e.Message}");
                }
            }
            Log($"done: {count} replies, {view.Number - count} pictures skipped");
        }

        private Message Take(int number)
        {
            TestCamera.Draw(pixels, number);
            if (!jpeg) return TestCamera.Frame(number, pixels);
            texture.LoadRawTextureData(pixels);
            return TestCamera.Jpeg(number, texture.EncodeToJPG());
        }

        private void OnDestroy() => Destroy(texture);
    }
}
