// REQ and REP: strict alternation, timeouts, late replies, content of every kind.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Linq;
using System.Text;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample.Conformance
{
    internal static class RequestReply
    {
        internal static void Run()
        {
            Hello();
            ConnectionStrings();
            Alternation();
            Waiting();
            LateReply();
            Content();
            Envelopes();
            SeveralServers();
        }

        private static void Hello()
        {
            using var server = new ResponseSocket();
            var port = server.BindRandomPort("tcp://127.0.0.1");
            using var client = new RequestSocket();
            client.Connect($"tcp://127.0.0.1:{port}");
            client.SendFrame("Hello");
            Say.That("request", Say.Received(server));
            server.SendFrame("World");
            Say.That("reply", Say.Received(client));
            Say.That("last endpoint is the bound one", server.Options.LastEndpoint == $"tcp://127.0.0.1:{port}");
            Say.That("client's last endpoint", client.Options.LastEndpoint == $"tcp://127.0.0.1:{port}");
        }

        private static void ConnectionStrings()
        {
            using var binds = new ResponseSocket("tcp://127.0.0.1:0");
            using var alsoBinds = new DealerSocket("@tcp://127.0.0.1:0");
            using var connects = new RequestSocket(binds.Options.LastEndpoint);
            using var alsoConnects = new RouterSocket(">" + alsoBinds.Options.LastEndpoint);
            using var both = new DealerSocket($" @tcp://127.0.0.1:0 , >{binds.Options.LastEndpoint},, ");
            using var neither = new PairSocket("");
            connects.SendFrame("by default");
            Say.That("default action", Say.Received(binds));
            binds.SendFrame("ok");
            both.SendMoreFrameEmpty().SendFrame("by prefix");
            Say.That("comma and prefix", Say.Received(binds));
            binds.SendFrame("ok");
            alsoBinds.SendFrame("to the router");
            var message = alsoConnects.ReceiveMultipartMessage();
            Say.That("router that connects", $"{message.FrameCount} frames, {message.Last.ConvertToString()}");
            Say.That("no address", neither.Options.LastEndpoint);
        }

        private static void Alternation()
        {
            using var server = new ResponseSocket("@inproc://alternation");
            using var client = new RequestSocket(">inproc://alternation");
            Say.ThrowsText("receive before request", () => client.TryReceiveFrameString(out _));
            Say.ThrowsText("reply before request", () => server.SendFrame("World"));
            client.SendFrame("Hello");
            Say.ThrowsText("second request", () => client.SendFrame("Hello"));
            Say.ThrowsText("second request, trying", () => client.TrySendFrame("Hello"));
            Say.That("error code", (Say.Thrown(() => client.SendFrame("Hello")) as NetMQException)?.ErrorCode);
            Say.That("request", Say.Received(server));
            Say.ThrowsText("second receive", () => server.TryReceiveFrameString(Say.Moment, out _));
            server.SendFrame("World");
            Say.ThrowsText("second reply", () => server.SendFrame("World"));
            Say.That("reply after all that", Say.Received(client));
            Say.ThrowsText("second reply wanted", () => client.ReceiveFrameString());
            client.SendMoreFrame("two").SendFrame("frames");
            Say.That("two frames are one request", Say.Received(server));
        }

        private static void Waiting()
        {
            using var server = new ResponseSocket("@inproc://waiting");
            using var client = new RequestSocket(">inproc://waiting");
            var clock = Stopwatch.StartNew();
            Say.That("nothing there", server.TryReceiveFrameString(out var text));
            Say.That("not waited", clock.ElapsedMilliseconds < 5000);
            Say.That("text", text);
            clock.Restart();
            Say.That("nothing came",
                server.TryReceiveFrameString(TimeSpan.FromMilliseconds(100), out text, out var more));
            Say.That("waited", clock.ElapsedMilliseconds >= 95);
            Say.That("text, more", $"{text ?? "null"}, {more}");
            client.SendFrame("Hello");
            Say.That("in time", server.TryReceiveFrameString(Say.Timeout, out text));
            Say.That("text", text);
            Say.That("no reply", client.TryReceiveFrameBytes(Say.Moment, out var bytes));
            Say.That("bytes", bytes);
            Say.ThrowsText("after a timeout", () => client.SendFrame("again"));
        }

        private static void LateReply()
        {
            using var server = new RouterSocket("@tcp://127.0.0.1:0");
            using var client = new RequestSocket();
            client.Options.Relaxed = true;
            client.Options.Correlate = true;
            client.Connect(server.Options.LastEndpoint!);
            client.SendFrame("first");
            var first = server.ReceiveMultipartMessage();
            Say.That("frames of a numbered request", first.FrameCount);
            Say.That("size of the number", first[1].MessageSize);
            Say.That("no reply", client.TryReceiveFrameString(Say.Moment, out _));
            Say.That("second request", client.TrySendFrame(Say.Timeout, "second"));
            var second = server.ReceiveMultipartMessage();
            Say.That("numbers differ", first[1] != second[1]);
            Answer(server, first, "late");
            Answer(server, second, "in time");
            Say.That("the reply that counts", Say.Received(client));

            using var relaxed = new RequestSocket();
            relaxed.Options.Relaxed = true;
            relaxed.Connect(server.Options.LastEndpoint!);
            relaxed.SendFrame("third");
            Say.That("relaxed only", Say.Received(server).EndsWith("|third", StringComparison.Ordinal));
            relaxed.SendFrame("fourth");
            Say.That("relaxed again", Say.Received(server).EndsWith("|fourth", StringComparison.Ordinal));
            Say.ThrowsText("read back", () => _ = relaxed.Options.Relaxed);
            Say.ThrowsText("read back", () => _ = client.Options.Correlate);
        }

        private static void Answer(RouterSocket server, NetMQMessage request, string text)
        {
            var reply = new NetMQMessage(request.Take(request.FrameCount - 1));
            reply.Append(text);
            server.SendMultipartMessage(reply);
        }

        private static void Content()
        {
            using var server = new ResponseSocket("@tcp://127.0.0.1:0");
            using var client = new RequestSocket(server.Options.LastEndpoint);

            byte[] Echo(byte[] content)
            {
                client.SendFrame(content);
                if (!server.TryReceiveFrameBytes(Say.Timeout,
                    out var there)) return Encoding.ASCII.GetBytes("no request");
                server.SendFrame(there);
                return client.TryReceiveFrameBytes(Say.Timeout, out var back) ? back
                    : Encoding.ASCII.GetBytes("no reply");
            }

            foreach (var size in new[] { 0, 1, 32, 33, 34, 255, 256, 8191, 8192, 8193, 10_000_000 })
            {
                var content = new byte[size];
                new Random(size).NextBytes(content);
                Say.That($"{size} bytes", Echo(content).SequenceEqual(content));
            }
            foreach (var text in new[] { "", "Grüße, 世界 🙂", "line\nline\0zero", new string('x', 600) + "é" })
            {
                client.SendFrame(text);
                Say.That("text there", server.ReceiveFrameString() == text);
                server.SendFrame(text);
                Say.That("text back", client.ReceiveFrameString() == text);
            }
            client.SendFrame(new byte[] { 72, 0xC3, 0x28, 0xFF, 105 });
            Say.That("invalid UTF-8", server.ReceiveFrameString());
            server.SendFrame(Encoding.Unicode.GetBytes("wide"), 4);
            Say.That("part of an array, another encoding", client.ReceiveFrameString(Encoding.Unicode));
            client.SendFrameEmpty();
            Say.That("empty", server.ReceiveFrameBytes().Length);
            server.SendMoreFrameEmpty().SendMoreFrame("").SendMoreFrame(new byte[0]).SendFrameEmpty();
            Say.That("four empty frames", client.ReceiveMultipartBytes().Count);
        }

        private static void Envelopes()
        {
            using var router = new RouterSocket("@inproc://envelope-router");
            using var client = new RequestSocket();
            client.Options.Identity = Encoding.ASCII.GetBytes("client");
            client.Connect("inproc://envelope-router");
            client.SendFrame("question");
            Say.That("a router sees", Say.Received(router));
            router.SendMoreFrame("client").SendMoreFrameEmpty().SendFrame("answer");
            Say.That("the client sees", Say.Received(client));

            using var server = new ResponseSocket("@inproc://envelope-server");
            using var dealer = new DealerSocket(">inproc://envelope-server");
            dealer.SendMoreFrame("address").SendMoreFrameEmpty().SendFrame("question");
            Say.That("a server sees", Say.Received(server));
            server.SendFrame("answer");
            Say.That("the dealer sees", Say.Received(dealer));
            dealer.SendFrame("without an empty frame");
            dealer.SendMoreFrameEmpty().SendFrame("with one");
            Say.That("what is malformed is dropped", Say.Received(server));
        }

        private static void SeveralServers()
        {
            using var one = new ResponseSocket("@inproc://server-1");
            using var two = new ResponseSocket("@inproc://server-2");
            using var client = new RequestSocket(">inproc://server-1,>inproc://server-2");
            var answers = new List<string>();
            for (var i = 0; i < 4; i++)
            {
                client.SendFrame("who?");
                var served = Say.Soon(() => one.HasIn || two.HasIn);
                var server = one.HasIn ? one : two;
                if (!served) break;
                server.SkipFrame();
                server.SendFrame(server == one ? "one" : "two");
                answers.Add(Say.Received(client));
            }
            Say.That("in turn", answers);
        }
    }
}
