// For Window > General > Test Runner, PlayMode: lesson 01 in Unity itself, its last line and its errors.
using System.Collections;
using System.Text.RegularExpressions;
using NetMQ;
using NUnit.Framework;
using UnityEngine;
using UnityEngine.TestTools;

namespace NetMQExample.Tests
{
    public class HelloClientTests
    {
        private static readonly int[] Plays = { 1, 2, 3, 4, 5 };

        // Each Play finds NetMQ as the one before has left it.
        [UnityTest]
        public IEnumerator GetsItsReplies([ValueSource(nameof(Plays))] int play)
        {
            using var server = InProcessServer.Answering(
                request => new NetMQMessage(new[] { new NetMQFrame("World") }));
            var client = (HelloClient)Scene.Play(typeof(HelloClient), null, server.Endpoint, ("count", 3));
            LogAssert.Expect(LogType.Log, "3: sent Hello, received World");
            LogAssert.Expect(LogType.Log, "done: 3 replies");
            yield return Scene.Until(() => client.Done, $"the end of Play {play}");
            Object.Destroy(client.gameObject);
        }

        [UnityTest]
        public IEnumerator SaysWhatIsWrongWithAnEndpoint()
        {
            var client = (HelloClient)Scene.Play(typeof(HelloClient), null, "127.0.0.1:5551");
            LogAssert.Expect(LogType.Error, new Regex("write it like tcp://"));
            yield return Scene.Until(() => client.Done, "an error");
            Assert.That(client.LastError, Does.Contain("write it like tcp://"));
            Object.Destroy(client.gameObject);
        }
    }
}
