// How the known examples do it. Never take these home: they are here to show that the test sees what is wrong.
using System;
using System.Diagnostics;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;
using UnityEngine;
using Debug = UnityEngine.Debug;

namespace NetMQExample.PlayTest
{
    /// <summary>Talks on a thread of its own from Start to OnDestroy.</summary>
    public abstract class NaiveClient : MonoBehaviour
    {
        [SerializeField] protected string endpoint = "tcp://127.0.0.1:5551";

        protected volatile bool running = true;
        protected Thread thread;
        protected string who;

        protected abstract void Ask();

        private void Start()
        {
            who = name;
            thread = new Thread(Ask) { IsBackground = true };
            thread.Start();
        }
    }

    /// <summary>Waits for each reply without a limit, and OnDestroy waits for that.</summary>
    public sealed class EndlessClient : NaiveClient
    {
        protected override void Ask()
        {
            using var socket = new RequestSocket(endpoint);
            while (running)
            {
                socket.SendFrame("Hello");
                Debug.Log($"{who}: asked");
                Debug.Log($"{who}: received {socket.ReceiveFrameString()}");
            }
        }

        private void OnDestroy()
        {
            running = false;
            thread.Join();
            NetMQConfig.Cleanup();
        }
    }

    /// <summary>Forgets its socket, so that NetMQ never ends. Before 4.0.4.1 it never does on macOS.</summary>
    public sealed class ForgetfulClient : NaiveClient
    {
        private static RequestSocket forgotten;

        internal static void Forget(string endpoint)
        {
            using var lifetime = new NetMQLifetime();
            forgotten = new RequestSocket(endpoint);
        }

        protected override void Ask()
        {
            var waited = Stopwatch.StartNew();
            try
            {
                using var lifetime = new NetMQLifetime();
                forgotten = new RequestSocket(endpoint);
                forgotten.SendFrame("Hello");
                Debug.Log("asked");
                while (running) Thread.Sleep(5);
            }
            catch (TimeoutException e)
            {
                Debug.LogError($"gave up after {waited.ElapsedMilliseconds} ms: {e.Message}");
            }
        }

        private void OnDestroy()
        {
            running = false;
            NetworkThread.Join(thread);
        }
    }

    /// <summary>Waits with a limit, but cleans up what its neighbours still use.</summary>
    public sealed class CleaningClient : NaiveClient
    {
        protected override void Ask()
        {
            try
            {
                using var socket = new RequestSocket(endpoint);
                while (running)
                {
                    socket.SendFrame("Hello");
                    string reply;
                    while (!socket.TryReceiveFrameString(TimeSpan.FromMilliseconds(50), out reply))
                        if (!running) return;
                    Debug.Log($"{who}: received {reply}");
                }
            }
            catch (Exception e) { Debug.LogError($"{who}: {e.GetType().Name}"); }
        }

        private void OnDestroy()
        {
            running = false;
            thread.Join();
            NetMQConfig.Cleanup(false);
        }
    }
}
