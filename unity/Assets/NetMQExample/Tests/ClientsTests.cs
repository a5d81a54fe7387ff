// For Window > General > Test Runner, PlayMode: every client of the lessons, against servers in the same process.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using System.Text;
using System.Text.RegularExpressions;
using System.Threading;
using NetMQ;
using NetMQExample.MLAgents.SideChannels;
using NUnit.Framework;
using UnityEngine;
using UnityEngine.TestTools;

namespace NetMQExample.Tests
{
    public class ClientsTests
    {
        // Every component that connects is in it, also those of lessons that come later.
        private static readonly Type[] Clients = typeof(ConnectedBehaviour).Assembly.GetTypes()
            .Where(type => typeof(ConnectedBehaviour).IsAssignableFrom(type) && !type.IsAbstract).ToArray();

        // A server of a few words can answer these.
        private static readonly Talk[] Talks =
        {
            new Talk(typeof(HelloClient), request => Frames("World"), "^1: sent Hello, received World$"),
            new Talk(typeof(LazyPirateClient), WithId("1"), "^1: sent add 1, received 1$"),
            new Talk(typeof(PoseFollower), number => $"pose/ {number} 0 0 0 0 0 0 1", "^received pose/ "),
            new Talk(typeof(HelloBackground), WithId("world"), "^1: sent hello.*, received world$"),
            new Talk(typeof(MessagesClient), Reply("frame", ("x", 7L), ("y", 3L)), "brightest at x 7, y 3$"),
            new Talk(typeof(ManyClient), WithId("0"), "^[0-9]+: sent "),
            new Talk(typeof(CatchUpFollower), _ => "pose/ a 2 0 0 0 0 0 0 1", "^2: at "),
            new Talk(typeof(CameraSender), Reply("action", ("throttle", 1.0), ("brake", 0.0), ("steer", 0.0)),
                "^frame [0-9]+: age ", typeof(DrivenCar)),
            new Talk(typeof(GymManager), Reply("welcome"), "^simulating CartPole ", typeof(CartPoleAgent)),
            new Talk(typeof(PursuitGame), Reply("welcome"), "^simulating Pursuit "),
            new Talk(typeof(CoinField), Reply("welcome"), "^simulating Coins ", typeof(CoinCarAgent)),
            new Talk(typeof(ViewRecorder), Reply("welcome"), " can film front .*, map ", typeof(FilmedDrive)),
            new Talk(typeof(SideChannelClient), request => Seen(), "^1: mass "),
            new Talk(typeof(JobRunner), Reply("result", Succeeded), "succeeded"),
            // Without keys, which would stay on this machine.
            new Talk(typeof(SecureHello), request => Frames("World"), "^1: sent Hello, received World$"),
            new Talk(typeof(FleetMember), Reply("welcome"), "^simulating "),
            new Talk(typeof(BodyTracker), number => $"pose/0/ {number} 0.0", "^person 0: pose .*, nobody is there$"),
            new Talk(typeof(TalkingCharacter), Reply("result", Succeeded), "^done: "),
        };

        private static (string, object)[] Succeeded =>
            new (string, object)[]
            {
                ("seq", 1L), ("status", "succeeded"), ("done", 1L), ("total", 1L), ("text", "Good day."),
            };

        [UnityTest]
        public IEnumerator GetsItsFirstReply([ValueSource(nameof(Talks))] Talk talk)
        {
            var lines = new List<string>();
            var events = new List<string>();
            void Hear(string line, string stack, LogType type) => lines.Add(line);
            Application.logMessageReceived += Hear;
            MonoBehaviour client;
            using (var server = talk.Serve())
            // Where lesson 07's asks what the stream begins with.
            using (var snapshots = InProcessServer.Answering(request => Frames("0 pose/ a 1 0 0 0 0 0 0 1")))
            {
                client = Scene.Play(talk.Client, talk.Beside, server.Endpoint,
                    ("every", 1), ("snapshots", snapshots.Endpoint), ("plain", true));
                foreach (var part in client.GetComponentsInChildren<MonoBehaviour>()) Listen(part, events);
                yield return Scene.Until(() => lines.Any(talk.Line.IsMatch), $"a line like {talk.Line}");
                yield return Scene.Until(() => events.Count == 0, $"its events {string.Join(" ", events)}");
            }
            Application.logMessageReceived -= Hear;
            yield return Scene.End(client);
        }

        private static readonly Type[] Askers = { typeof(HelloClient), typeof(HelloBackground) };

        [UnityTest]
        public IEnumerator TellsOfEachReplyAfterItsLine([ValueSource(nameof(Askers))] Type type)
        {
            var heard = new List<string>();
            void Hear(string line, string stack, LogType type) => heard.Add(line);
            Application.logMessageReceived += Hear;
            var plain = type == typeof(HelloClient);
            // All is asked before the first answer is there, and the others come while that is heard.
            var answer = WithId("World");
            var slow = TimeSpan.FromSeconds(0.05);
            using var server = InProcessServer.Answering(request =>
            {
                Thread.Sleep(slow);
                return plain ? Frames("World") : answer(request);
            });
            var client = Scene.Play(type, null, server.Endpoint, ("count", 3));
            var replied = type.GetEvent("Replied");
            replied.AddEventHandler(client, (Action<string>)heard.Add);
            Action<string> listen = _ => Thread.Sleep(5 * slow);
            replied.AddEventHandler(client, listen);
            // A client that is disabled in an event gets no more of them, also none that wait for the same frame.
            Action<string> enough = _ => client.enabled = heard.Count(one => one == "World") < 2;
            replied.AddEventHandler(client, enough);
            yield return Scene.Until(() => !client.enabled, "the second reply");
            for (var frames = 0; frames < 5; frames++) yield return null;
            Application.logMessageReceived -= Hear;
            UnityEngine.Object.Destroy(client.gameObject);
            var sent = plain ? "Hello" : "hello";
            Assert.That(heard.SkipWhile(one => !one.StartsWith("1:")), Is.EqualTo(new[]
            {
                $"1: sent {sent}, received World", "World", $"2: sent {sent}, received World", "World",
            }));
        }

        [UnityTest]
        public IEnumerator StopsAtOnceWithoutAServer([ValueSource(nameof(Clients))] Type type)
        {
            // Some give up at once, as lesson 15's without its keys.
            LogAssert.ignoreFailingMessages = true;
            var client = Scene.Play(type, null, "tcp://127.0.0.1:9");
            for (var frames = 0; frames < 5; frames++) yield return null;
            yield return Scene.End(client);
        }

        private static readonly int[] Plays = { 1, 2, 3, 4, 5 };

        // Each Play finds NetMQ as the one before has left it.
        [UnityTest]
        public IEnumerator GetsItsReplies([ValueSource(nameof(Plays))] int play)
        {
            using var server = InProcessServer.Answering(request => Frames("World"));
            var client = (HelloClient)Scene.Play(typeof(HelloClient), null, server.Endpoint, ("count", 3));
            LogAssert.Expect(LogType.Log, "3: sent Hello, received World");
            LogAssert.Expect(LogType.Log, "done: 3 replies");
            yield return Scene.Until(() => client.Done, $"the end of Play {play}");
            UnityEngine.Object.Destroy(client.gameObject);
        }

        [UnityTest]
        public IEnumerator SaysWhatIsWrongWithAnEndpoint()
        {
            var client = (HelloClient)Scene.Play(typeof(HelloClient), null, "127.0.0.1:5551");
            LogAssert.Expect(LogType.Error, new Regex("write it like tcp://"));
            yield return Scene.Until(() => client.Done, "an error");
            Assert.That(client.LastError, Does.Contain("write it like tcp://"));
            UnityEngine.Object.Destroy(client.gameObject);
        }

        // Of each event two are expected: what the inspector wires, and what a script adds itself to.
        private static void Listen(MonoBehaviour component, List<string> expected)
        {
            const BindingFlags own = BindingFlags.Instance | BindingFlags.NonPublic | BindingFlags.DeclaredOnly;
            for (var type = component.GetType(); type != typeof(MonoBehaviour); type = type.BaseType)
                foreach (var field in type.GetFields(own).Where(field => field.FieldType.IsGenericType
                    && field.FieldType.GetGenericTypeDefinition() == typeof(Arrival<>)))
                    typeof(ClientsTests).GetMethod(nameof(ListenTo), BindingFlags.Static | BindingFlags.NonPublic)
                        .MakeGenericMethod(field.FieldType.GetGenericArguments())
                        .Invoke(null, new[] { component, field.Name, field.GetValue(component), expected });
        }

        private static void ListenTo<T>(MonoBehaviour component, string name, Arrival<T> arrival, List<string> expected)
        {
            var script = component.GetType().GetEvent(char.ToUpperInvariant(name[0]) + name.Substring(1));
            expected.AddRange(new[] { name, script.Name });
            arrival.AddListener(_ => expected.Remove(name));
            script.AddEventHandler(component, new Action<T>(_ => expected.Remove(script.Name)));
        }

        private static NetMQMessage Frames(params string[] texts) =>
            new NetMQMessage(texts.Select(text => new NetMQFrame(text)));

        private static Func<NetMQMessage, NetMQMessage> WithId(string text) =>
            request => new NetMQMessage(new[] { request.First, new NetMQFrame(text) });

        // A message of lesson 05.
        private static Func<NetMQMessage, NetMQMessage> Reply(
            string kind, params (string Name, object Value)[] values) => request =>
            {
                var asked = Message.Read(request.Select(frame => (ReadOnlyMemory<byte>)frame.ToByteArray()).ToArray());
                var reply = new Message(kind, asked.Id);
                // Lesson 08's is about a picture, and lesson 14's about a job.
                foreach (var about in new[] { "frame", "job" })
                    if (asked.Values.TryGetValue(about, out var which)) reply.Values[about] = which;
                foreach (var (name, value) in values) reply.Values[name] = value;
                return Frames(reply.Header());
            };

        // An exchange of lesson 13, with one message of 12 bytes: the property "seen" is 0, so that round 1 begins.
        private static NetMQMessage Seen() =>
            new NetMQMessage(new[] { new FloatPropertiesChannel().ChannelId.ToByteArray()
                .Concat(Encoding.ASCII.GetBytes("\x0c\0\0\0\x04\0\0\0seen\0\0\0\0")).ToArray() });

        /// <summary>A client, what its server answers or publishes, a line that it logs then, and what it needs beside
        /// it.</summary>
        public sealed class Talk
        {
            public readonly Type Client, Beside;
            public readonly Func<InProcessServer> Serve;
            public readonly Regex Line;

            public Talk(Type client, Func<NetMQMessage, NetMQMessage> answer, string line, Type beside = null)
            {
                Client = client;
                Serve = () => InProcessServer.Answering(answer);
                Line = new Regex(line);
                Beside = beside;
            }

            public Talk(Type client, Func<int, string> text, string line)
            {
                Client = client;
                Serve = () => InProcessServer.Publishing(text);
                Line = new Regex(line);
            }

            public override string ToString() => Client.Name;
        }
    }
}
