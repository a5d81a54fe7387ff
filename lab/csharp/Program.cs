// The C# clients of the performance lab. kit.py bench starts this, and says on the standard input what to do, a line each:
//
//     echo NAME ENDPOINT SIZE SECONDS [CLIENTS]       each client sends and has it back, again and again
//     stream NAME ENDPOINT SIZE SECONDS               sends without waiting; only the last message is answered
//     publish NAME ENDPOINT SIZE COUNT CLIENTS        the server sends COUNT messages to each of the clients
//     first NAME ENDPOINT SIZE                        a new client's first answer
//     frames ENDPOINT COUNT                           lesson 04's client in the player, COUNT frames
//     close                                           disposes the clients, which otherwise stay for the next line
//
// With the word `pool` on its command line it leaves .NET's sockets as they are.
// Each line is answered with one line of JSON: messages, seconds, and how long each wait was in
// microseconds. Clients stay connected from round to round, so that a round measures no start.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Globalization;
using System.Linq;
using NetMQ;
using UnityEngine;
using UnityPlayer;

namespace NetMQExample.Lab
{
    internal static class Program
    {
        private static readonly Dictionary<string, Contender[]> Open = new Dictionary<string, Contender[]>();

        private static void Main(string[] words)
        {
            // As csharp-console/Program.cs does it, unless the lab wants to see what it is worth.
            if (words.Length == 0) Environment.SetEnvironmentVariable("DOTNET_SYSTEM_NET_SOCKETS_INLINE_COMPLETIONS", "1");
            // NetMQ's threads stay while any client of this program does.
            using var lifetime = new NetMQLifetime();
            // Its standard is 1024, and a thousand clients of each of two kinds are open at once.
            NetMQConfig.MaxSockets = 4096;
            for (var line = Console.ReadLine(); line != null; line = Console.ReadLine())
            {
                try
                {
                    Console.WriteLine(Answer(line.Split(' ')));
                }
                catch (Exception e)
                {
                    Console.WriteLine($"failed: {line}: {e.GetType().Name}: {e.Message.Split('\n')[0]}");
                }
            }
        }

        private static string Answer(string[] words)
        {
            switch (words[0])
            {
                case "echo":
                    return Measure(Clients(words[1], words[2], Whole(words[3]), words.Length > 5 ? Whole(words[5]) : 1), double.Parse(words[4], CultureInfo.InvariantCulture), Echo);
                case "stream":
                    return Measure(Clients(words[1], words[2], Whole(words[3]), 1), double.Parse(words[4], CultureInfo.InvariantCulture), Stream);
                case "publish":
                    return Measure(Clients(words[1], words[2], Whole(words[3]), Whole(words[5])), Whole(words[4]), Publish);
                case "first":
                    return Measure(new Contender[0], 0, (none, limit, waits) =>
                    {
                        using var client = Contender.Make(words[1], words[2], Whole(words[3]));
                        return client.Echo(waits);
                    });
                case "frames":
                    return Frames(words[1], words[2]);
                default:
                    foreach (var client in Open.Values.SelectMany(clients => clients)) client.Dispose();
                    Open.Clear();
                    return "{}";
            }
        }

        private static int Whole(string word) => int.Parse(word, CultureInfo.InvariantCulture);

        private static Contender[] Clients(string name, string endpoint, int size, int count)
        {
            var key = $"{name} {endpoint} {size} {count}";
            if (!Open.TryGetValue(key, out var clients))
                Open[key] = clients = Enumerable.Range(0, count).Select(i => Contender.Make(name, endpoint, size)).ToArray();
            return clients;
        }

        private static string Measure(Contender[] clients, double limit, Func<Contender[], double, List<double>, int> work)
        {
            var waits = new List<double>(1 << 16);
            var watch = Stopwatch.StartNew();
            var messages = work(clients, limit, waits);
            var seconds = watch.Elapsed.TotalSeconds;
            var listed = string.Join(",", waits.Select(wait => wait.ToString("F1", CultureInfo.InvariantCulture)));
            return FormattableString.Invariant(
                $"{{\"messages\":{messages},\"seconds\":{seconds:F6},\"waits\":[{listed}]}}");
        }

        private static int Echo(Contender[] clients, double seconds, List<double> waits)
        {
            var messages = 0;
            for (var watch = Stopwatch.StartNew(); watch.Elapsed.TotalSeconds < seconds;)
            {
                if (clients.Length == 1)
                {
                    messages += clients[0].Echo(waits);
                    continue;
                }
                // Each client has one request under way, and all of them at the same time.
                foreach (var client in clients) client.Send();
                foreach (var client in clients) client.Receive();
                messages += clients.Length;
            }
            return messages;
        }

        private static int Stream(Contender[] clients, double seconds, List<double> waits)
        {
            var messages = 1;
            clients[0].Payload[0] = Contender.NoAnswer;
            for (var watch = Stopwatch.StartNew(); watch.Elapsed.TotalSeconds < seconds; messages++) clients[0].Send();
            clients[0].Payload[0] = Contender.Answer;
            clients[0].Send();
            clients[0].Receive();
            return messages;
        }

        private static int Publish(Contender[] clients, double count, List<double> waits)
        {
            var payload = clients[0].Payload;
            payload[0] = Contender.Publish;
            BitConverter.GetBytes(clients.Length).CopyTo(payload, 1);
            BitConverter.GetBytes((int)count).CopyTo(payload, 5);
            clients[0].Send();
            foreach (var client in clients)
                for (var i = 0; i < count; i++) client.Receive();
            return (int)count * clients.Length;
        }

        // What the player logs, with the line "measured: …", comes before the answer.
        private static string Frames(string endpoint, string count)
        {
            var player = new Player(typeof(MeasuredBackground).Assembly);
            player.Begin(() =>
            {
                var thing = new GameObject("measured");
                thing.SetActive(false);
                var script = (MonoBehaviour)thing.AddComponent(typeof(MeasuredBackground));
                Inspector.Set(new[] { script }, "endpoint", endpoint);
                Inspector.Set(new[] { script }, "frames", count);
                thing.SetActive(true);
            });
            player.Run(TimeSpan.FromMinutes(1), () => false);
            player.Stop();
            return "{}";
        }
    }
}
