// For Window > General > Test Runner, PlayMode: lesson 01 in Unity itself, against a server in the same process.
using System;
using System.Collections;
using System.Diagnostics;
using System.Reflection;
using System.Text.RegularExpressions;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;
using NUnit.Framework;
using UnityEngine;
using UnityEngine.TestTools;
using Object = UnityEngine.Object;

namespace NetMQExample.Tests
{
    public class HelloClientTests
    {
        private static readonly int[] Plays = { 1, 2, 3, 4, 5 };

        [UnityTest]
        public IEnumerator GetsItsReplies()
        {
            using var server = new Server();
            var client = Create(server.Endpoint, 3);
            LogAssert.Expect(LogType.Log, "3: sent Hello, received World");
            LogAssert.Expect(LogType.Log, "done: 3 replies");
            yield return UntilDone(client);
            Object.Destroy(client.gameObject);
        }

        [UnityTest]
        public IEnumerator StopsAtOnceWithoutAServer([ValueSource(nameof(Plays))] int play)
        {
            var client = Create("tcp://127.0.0.1:9", 1000);
            for (var frames = 0; frames < 5; frames++) yield return null;
            var busy = Stopwatch.StartNew();
            Object.DestroyImmediate(client.gameObject);
            Assert.That(busy.ElapsedMilliseconds, Is.LessThan(50), $"Play {play} made the main thread wait");
        }

        [UnityTest]
        public IEnumerator SaysWhatIsWrongWithAnEndpoint()
        {
            var client = Create("127.0.0.1:5551", 1);
            LogAssert.Expect(LogType.Error, new Regex("write it like tcp://"));
            yield return UntilDone(client);
            Object.Destroy(client.gameObject);
        }

        // By time and not by frames: with -batchmode there are thousands a second.
        private static IEnumerator UntilDone(HelloClient client)
        {
            var time = Stopwatch.StartNew();
            while (!client.Done && time.Elapsed.TotalSeconds < 10) yield return null;
            Assert.That(client.Done, "no end within 10 s");
        }

        private static HelloClient Create(string endpoint, int count)
        {
            var thing = new GameObject(nameof(HelloClient));
            // Switched off, so that the fields are set before the component wakes up.
            thing.SetActive(false);
            var client = thing.AddComponent<HelloClient>();
            Set(client, "endpoint", endpoint);
            Set(client, "count", count);
            thing.SetActive(true);
            return client;
        }

        private static void Set(HelloClient client, string name, object value) =>
            typeof(HelloClient).GetField(name, BindingFlags.Instance | BindingFlags.NonPublic).SetValue(client, value);

        /// <summary>Answers World on a thread of its own, as python/01_request_reply/server.py does.</summary>
        private sealed class Server : IDisposable
        {
            private readonly ManualResetEventSlim listening = new ManualResetEventSlim();
            private readonly Thread thread;
            private volatile bool stopped;

            public Server()
            {
                thread = new Thread(Serve) { IsBackground = true };
                thread.Start();
                listening.Wait(2000);
            }

            public string Endpoint { get; private set; }

            public void Dispose()
            {
                stopped = true;
                Assert.That(thread.Join(2000), "the server did not end");
            }

            private void Serve()
            {
                using var lifetime = new NetMQLifetime();
                using var socket = new ResponseSocket();
                socket.Options.Linger = TimeSpan.Zero;
                Endpoint = $"tcp://127.0.0.1:{socket.BindRandomPort("tcp://127.0.0.1")}";
                listening.Set();
                while (!stopped)
                    if (socket.TryReceiveFrameString(TimeSpan.FromMilliseconds(50), out _)) socket.SendFrame("World");
            }
        }
    }
}
