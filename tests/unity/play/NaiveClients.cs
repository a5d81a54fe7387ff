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
    /// <summary>Waits for each reply without a limit, and OnDestroy waits for that.</summary>
    public sealed class EndlessClient : MonoBehaviour
    {
        [SerializeField] private string endpoint = "tcp://127.0.0.1:5551";

        private volatile bool running = true;
        private Thread thread;
        private string who;

        private void Start()
        {
            who = name;
            thread = new Thread(Ask) { IsBackground = true };
            thread.Start();
        }

        private void OnDestroy()
        {
            running = false;
            thread.Join();
            NetMQConfig.Cleanup();
        }

        private void Ask()
        {
            using var socket = new RequestSocket(endpoint);
            while (running)
            {
                socket.SendFrame("Hello");
                Debug.Log($"{who}: asked");
                Debug.Log($"{who}: received {socket.ReceiveFrameString()}");
            }
        }
    }

    /// <summary>Forgets its socket, so that NetMQ never ends. Before 4.0.4.1 it never does on macOS.</summary>
    public sealed class ForgetfulClient : MonoBehaviour
    {
        private static RequestSocket forgotten;

        [SerializeField] private string endpoint = "tcp://127.0.0.1:5551";

        private volatile bool running = true;
        private Thread thread;

        internal static void Forget(string endpoint)
        {
            using var lifetime = new NetMQLifetime();
            forgotten = new RequestSocket(endpoint);
        }

        private void Start()
        {
            thread = new Thread(Ask) { IsBackground = true };
            thread.Start();
        }

        private void OnDestroy()
        {
            running = false;
            NetworkThread.Join(thread);
        }

        private void Ask()
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
    }

    /// <summary>Waits with a limit, but cleans up what its neighbours still use.</summary>
    public sealed class CleaningClient : MonoBehaviour
    {
        [SerializeField] private string endpoint = "tcp://127.0.0.1:5551";

        private volatile bool running = true;
        private Thread thread;
        private string who;

        private void Start()
        {
            who = name;
            thread = new Thread(Ask) { IsBackground = true };
            thread.Start();
        }

        private void OnDestroy()
        {
            running = false;
            thread.Join();
            NetMQConfig.Cleanup(false);
        }

        private void Ask()
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
            catch (Exception e)
            {
                Debug.LogError($"{who}: {e.GetType().Name}");
            }
        }
    }
}
