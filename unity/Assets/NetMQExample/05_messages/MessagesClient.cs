// Lesson 05 in Unity: pictures go to Python from a thread of their own, and Update logs what comes back.
//
// Use: start python/05_messages/server.py, add this component to any GameObject, press Play.
// A picture is taken only when the last one was answered, so no old one ever waits in a queue: the newest wins. For your
// camera, fill the texture with ReadPixels, or take the bytes from AsyncGPUReadback, which does not make Unity wait.
using System;
using System.Collections.Concurrent;
using System.Threading;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Sends pictures to the server a number of times and logs where each is brightest.</summary>
    public sealed class MessagesClient : MonoBehaviour
    {
        [SerializeField] private string endpoint = "tcp://127.0.0.1:5555";
        [SerializeField] private int count = 10;
        [SerializeField, Tooltip("Seconds to wait for each reply")] private float patience = 2.5f;
        [SerializeField, Tooltip("How many pictures in a row may stay without a reply")] private int tries = 20;
        [SerializeField, Tooltip("The camera's pictures a second; 0: one for each reply")] private int fps;
        [SerializeField, Tooltip("Send JPEG instead of raw bytes")] private bool jpeg;

        private readonly ConcurrentQueue<Action> forUpdate = new ConcurrentQueue<Action>();
        private readonly byte[] pixels = new byte[TestCamera.Size];
        // Who may touch the pixels: Update while wanted is true, the network thread once there is a request.
        private readonly ConcurrentQueue<Message> requests = new ConcurrentQueue<Message>();
        private volatile bool wanted;
        private SemaphoreSlim taken;
        private CancellationTokenSource stop;
        private Texture2D texture;
        private TestCamera view;
        private Thread thread;

        /// <summary>True once the last reply, or the reason why there is none, was logged.</summary>
        public bool Done => !thread.IsAlive && forUpdate.IsEmpty;

        private void OnEnable()
        {
            // Without it Unity stops calling Update when another window has the focus.
            Application.runInBackground = true;
            texture = new Texture2D(TestCamera.Width, TestCamera.Height, TextureFormat.RGB24, false);
            view = new TestCamera(fps);
            taken = new SemaphoreSlim(0);
            stop = new CancellationTokenSource();
            wanted = false;
            requests.Clear();
            thread = new Thread(Ask) { IsBackground = true, Name = nameof(MessagesClient) };
            thread.Start(stop.Token);
        }

        private void Update()
        {
            while (forUpdate.TryDequeue(out var action)) action();
            if (!wanted || !view.Look()) return;
            wanted = false;
            TestCamera.Draw(pixels, view.Number);
            texture.LoadRawTextureData(pixels);
            // Only the main thread may read a texture. GetRawTextureData<byte>() is a view: nothing new is made.
            if (!jpeg) texture.GetRawTextureData<byte>().CopyTo(pixels);
            requests.Enqueue(jpeg ? TestCamera.Jpeg(view.Number, texture.EncodeToJPG()) : TestCamera.Frame(view.Number, pixels));
            taken.Release();
        }

        // Unity tells all objects before it disables the first: on Stop ten clients then end in the time of one.
        private void OnApplicationQuit() => stop?.Cancel();

        private void OnDisable()
        {
            stop.Cancel();
            // It ends within 50 ms, and is never waited for longer than 200: Stop must not freeze the editor.
            NetMQLifetime.Join(thread);
            Destroy(texture);
        }

        private void Ask(object token)
        {
            var cancelled = (CancellationToken)token;
            try
            {
                Log($"asking {endpoint}");
                using var requester = new MessageRequester(endpoint);
                for (int i = 1, lost = 0; i <= count;)
                {
                    wanted = true;
                    taken.Wait(cancelled);
                    requests.TryDequeue(out var request);
                    try
                    {
                        var reply = requester.Request(request, TimeSpan.FromSeconds(patience), cancelled);
                        Log(TestCamera.Describe(i++, request, reply));
                        lost = 0;
                    }
                    catch (TimeoutException e) when (++lost < tries)
                    {
                        // This picture is not sent again: by now there is a newer one.
                        Log($"trouble: {e.Message}");
                    }
                }
                Log($"done: {count} replies, {view.Number - count} pictures skipped");
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
