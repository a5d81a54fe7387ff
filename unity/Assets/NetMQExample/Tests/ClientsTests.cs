// For Window > General > Test Runner, PlayMode: every client of the lessons, against servers in the same process.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Linq;
using System.Text.RegularExpressions;
using NetMQ;
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

        // What a server of a few words can answer.
        private static readonly Talk[] Talks =
        {
            new Talk(typeof(HelloClient), request => Frames("World"), "^1: sent Hello, received World$"),
            new Talk(typeof(LazyPirateClient), WithId("1"), "^1: sent add 1, received 1$"),
            new Talk(typeof(PoseFollower), number => $"pose/ {number} 0 0 0 0 0 0 1", "^received pose/ "),
            new Talk(typeof(HelloBackground), WithId("world"), "^1: sent hello.*, received world$"),
            new Talk(typeof(MessagesClient), Reply("frame", ("x", 7L), ("y", 3L)), "brightest at x 7, y 3$"),
            new Talk(typeof(ManyClient), WithId("0"), "^[0-9]+: sent "),
            new Talk(typeof(JobRunner), Reply("result", Succeeded), "succeeded"),
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
            void Hear(string line, string stack, LogType type) => lines.Add(line);
            Application.logMessageReceived += Hear;
            ConnectedBehaviour client;
            using (var server = talk.Serve())
            {
                client = Scene.Play(talk.Client, server.Endpoint, ("every", 1));
                yield return Scene.Until(() => lines.Any(talk.Line.IsMatch), $"a line like {talk.Line}");
            }
            Application.logMessageReceived -= Hear;
            yield return Scene.End(client);
        }

        [UnityTest]
        public IEnumerator StopsAtOnceWithoutAServer([ValueSource(nameof(Clients))] Type type)
        {
            // Some give up at once, as lesson 15's without its keys.
            LogAssert.ignoreFailingMessages = true;
            var client = Scene.Play(type, "tcp://127.0.0.1:9");
            for (var frames = 0; frames < 5; frames++) yield return null;
            yield return Scene.End(client);
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
                // Lesson 14's name a job.
                if (asked.Values.TryGetValue("job", out var job)) reply.Values["job"] = job;
                foreach (var (name, value) in values) reply.Values[name] = value;
                return Frames(reply.Header());
            };

        /// <summary>A client, what its server answers or publishes, and a line that it logs then.</summary>
        public sealed class Talk
        {
            public readonly Type Client;
            public readonly Func<InProcessServer> Serve;
            public readonly Regex Line;

            public Talk(Type client, Func<NetMQMessage, NetMQMessage> answer, string line) =>
                (Client, Serve, Line) = (client, () => InProcessServer.Answering(answer), new Regex(line));

            public Talk(Type client, Func<int, string> text, string line) =>
                (Client, Serve, Line) = (client, () => InProcessServer.Publishing(text), new Regex(line));

            public override string ToString() => Client.Name;
        }
    }
}
