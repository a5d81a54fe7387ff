// A C# program that serves, for clients of any kind: checks.dll server serve [ENDPOINT]. And what no client of the kit
// shows, in one process: checks.dll server alone.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Linq;
using System.Net;
using System.Net.Sockets;
using System.Text;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;
using static NetMQExample.Tests.BackgroundClientChecks;

namespace NetMQExample.Tests
{
    internal static class ServerChecks
    {
        public static int Run(string[] words)
        {
            if (words[0] == "alone") return Alone();
            var count = 0;
            string Answer(string text) => text switch
            {
                "hello" => "world",
                "count" => $"{++count}",
                "throw" => throw new InvalidOperationException($"no such thing\n{new string('x', 70_000)}"),
                "long" => new string('ä', 32_769),
                "null" => null,
                _ => text.StartsWith("echo ") ? text.Substring(5) : $"error: expected hello or echo TEXT, got '{text}'",
            };
            using var server = words.Length > 1 ? new Server(Answer, words[1]) : new Server(Answer);
            Console.WriteLine($"listening on {server.Endpoint}");
            server.Run(default);
            return 0;
        }

        private static int Alone()
        {
            // So that NetMQ goes on from one server to the next.
            using var lifetime = new NetMQLifetime();
            Taken();
            Again();
            Frames();
            Forgets();
            Ends();
            Reports();
            Console.WriteLine("ok");
            return 0;
        }

        private static void Taken()
        {
            using var first = new Server(text => text);
            Console.WriteLine(Throws<GaveUpException>(() => new Server(text => text, first.Endpoint)).Message);
            Console.WriteLine(
                Throws<GaveUpException>(
                    () => new Server(text => text, "tcp://192.0.2.1:0", openToAnyone: true)).Message);
            Console.WriteLine(Throws<ArgumentException>(() => new Server(text => text, "tcp://0.0.0.0:5554")).Message);
            using var open = new Server(text => text, "tcp://0.0.0.0:0", openToAnyone: true);
            Check(!open.Endpoint.EndsWith(":0"), open.Endpoint);
        }

        // A scene that is loaded again ends one server and begins the next in one frame, while clients are connected.
        private static void Again()
        {
            var endpoint = "tcp://127.0.0.1:0";
            using var client = new DealerSocket();
            for (var i = 0; i < 30; i++)
            {
                using var server = new Server(text => text, endpoint);
                if (i == 0) client.Connect(server.Endpoint);
                endpoint = server.Endpoint;
                Asked(client, server, "hi");
                server.Dispose();
            }
        }

        // Sends until there is a reply: what is sent to a server that ends at that moment is lost.
        private static string Asked(DealerSocket client, Server server, string text)
        {
            string reply = null;
            for (var waited = Stopwatch.StartNew(); ; Thread.Sleep(1))
            {
                Check(waited.Elapsed < TimeSpan.FromSeconds(60), "no reply");
                if (waited.ElapsedMilliseconds % 100 < 2) client.TrySendFrame(TimeSpan.Zero, text);
                server.Poll();
                if (client.TryReceiveFrameString(out reply)) return reply;
            }
        }

        // Requests that wait are answered in several frames of the game, and a Poll with nothing to do makes no
        // garbage.
        private static void Frames()
        {
            var on = Environment.CurrentManagedThreadId;
            using var server = new Server(text =>
            {
                Check(Environment.CurrentManagedThreadId == on, "on another thread");
                return text;
            });
            using var client = new DealerSocket(">" + server.Endpoint);
            for (var i = 0; i < 200; i++) client.SendFrame($"{i}");
            var most = 0;
            var replies = new List<string>();
            for (var waited = Stopwatch.StartNew(); replies.Count < 200; most = Math.Max(most, server.Poll()))
            {
                Check(waited.Elapsed < TimeSpan.FromSeconds(60), $"{replies.Count} replies");
                while (client.TryReceiveFrameString(out var reply)) replies.Add(reply);
            }
            Check(replies.SequenceEqual(Enumerable.Range(0, 200).Select(i => $"{i}")), "in another order");
            Check(most <= 50, $"{most} at once");
            var before = GC.GetAllocatedBytesForCurrentThread();
            for (var i = 0; i < 1000; i++) server.Poll();
            Console.WriteLine($"{(GC.GetAllocatedBytesForCurrentThread() - before) / 1000} bytes in a frame");
        }

        // Of a thousand and one answers the first is forgotten, and asked for anew.
        private static void Forgets()
        {
            var calls = 0;
            using var server = new Server(text => $"{++calls}");
            using var client = new DealerSocket(">" + server.Endpoint);
            string Ask(int number)
            {
                client.SendMoreFrame($"{number:D16}").SendFrame("same");
                for (var waited = Stopwatch.StartNew(); ; server.Poll())
                {
                    Check(waited.Elapsed < TimeSpan.FromSeconds(60), "no reply");
                    if (client.TryReceiveFrameString(out var id))
                        return id == $"{number:D16}" ? client.ReceiveFrameString() : id;
                }
            }
            for (var i = 1; i <= 1001; i++) Check(Ask(i) == $"{i}", "of another request");
            Check(Ask(2) == "2", "the second is forgotten as well");
            Check(Ask(1) == "1002", "the first is remembered");
            // Two clients behind one broker, each of which counts its requests from 1.
            foreach (var name in new[] { "anne", "bert" })
                client.SendMoreFrame(name).SendMoreFrame("").SendMoreFrame("1").SendFrame("same");
            var replies = new List<string>();
            for (var waited = Stopwatch.StartNew(); replies.Count < 8; server.Poll())
            {
                Check(waited.Elapsed < TimeSpan.FromSeconds(60), "no reply");
                while (client.TryReceiveFrameString(out var frame)) replies.Add(frame);
            }
            Check(string.Join(",", replies) == "anne,,1,1003,bert,,1,1004", string.Join(",", replies));
        }

        // A report that throws itself ends nothing.
        private static void Reports()
        {
            using var server = new Server(
                text => throw new FormatException(text), report: line => throw new InvalidOperationException(line));
            using var client = new DealerSocket(">" + server.Endpoint);
            Check(Asked(client, server, "hi") == "error: FormatException: hi", "another reply");
        }

        // Its own answer disposes it, as a script does that switches itself off.
        private static void Ends()
        {
            Server server = null;
            server = new Server(text =>
            {
                server.Dispose();
                return text;
            });
            using var client = new DealerSocket(">" + server.Endpoint);
            client.SendFrame("end");
            client.SendFrame("after");
            for (var polls = 0; polls == 0;) polls = server.Poll();
            server.Dispose();
            Console.WriteLine(Throws<ObjectDisposedException>(() => server.Poll()).Message);
            Throws<ObjectDisposedException>(() => server.Run(default));
            using var stop = new CancellationTokenSource();
            using var other = new Server(text => text);
            var thread = new Thread(() => other.Run(stop.Token));
            thread.Start();
            stop.Cancel();
            Check(thread.Join(60_000), "Run does not end");
        }
    }
}
