// The C# clients of the performance lab. kit.py bench starts this, and says on the standard input what to do, a line
// each:
//
//     echo NAME ENDPOINT SIZE SECONDS     a client sends and has it back, again and again
//     frames ENDPOINT COUNT               lesson 04's client in the player, COUNT frames
//     close                               disposes the clients, which otherwise stay for the next line
//
// Each line is answered with one line of JSON: messages, seconds, and how long each wait was in
// microseconds. Clients stay connected from round to round, so that a round measures no start.
// Started as `respond ENDPOINT SIZE` it answers what comes with SIZE bytes, for the lab's trainer, until its input
// ends; as `see WIDTH HEIGHT COUNT --endpoint ENDPOINT` it is a simulator of agents that see pictures.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Globalization;
using System.Linq;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;
using UnityEngine;
using UnityPlayer;

namespace NetMQExample.Lab
{
    internal static class Program
    {
        private static readonly Dictionary<string, Contender> Open = new Dictionary<string, Contender>();

        private static void Main(string[] words)
        {
            // As csharp-console/Program.cs does it.
            Environment.SetEnvironmentVariable("DOTNET_SYSTEM_NET_SOCKETS_INLINE_COMPLETIONS", "1");
            if (words.Length > 0)
            {
                if (words[0] == "respond") Respond(words[1], Whole(words[2]));
                else Seeing.Run(words[^1], Whole(words[1]), Whole(words[2]), Whole(words[3]));
                return;
            }
            // NetMQ's threads stay while any client of this program does.
            using var lifetime = new NetMQLifetime();
            for (var line = Console.ReadLine(); line != null; line = Console.ReadLine())
            {
                try { Console.WriteLine(Answer(line.Split(' '))); }
                catch (Exception e)
                {
                    Console.WriteLine($"failed: {line}: {e.GetType().Name}: {e.Message.Split('\n')[0]}");
                }
            }
        }

        // Answers whatever comes with so many bytes: what a simulator would do that has nothing to do.
        private static void Respond(string endpoint, int size)
        {
            using var lifetime = new NetMQLifetime();
            using var socket = new DealerSocket();
            socket.Options.Linger = TimeSpan.Zero;
            socket.Connect(endpoint);
            var ended = new ManualResetEventSlim();
            new Thread(() => { while (Console.In.Read() >= 0) { } ended.Set(); }) { IsBackground = true }.Start();
            var answer = new byte[size];
            var msg = new Msg();
            msg.InitEmpty();
            socket.SendFrame(answer);
            while (!ended.IsSet)
                if (socket.TryReceive(ref msg, TimeSpan.FromMilliseconds(100))) socket.SendFrame(answer);
            msg.Close();
        }

        private static int Whole(string word) => int.Parse(word, CultureInfo.InvariantCulture);

        private static string Answer(string[] words)
        {
            switch (words[0])
            {
                case "echo":
                    return Echo(Client(words[1], words[2], Whole(words[3])),
                        double.Parse(words[4], CultureInfo.InvariantCulture));
                case "frames":
                    return Frames(words[1], words[2]);
                default:
                    foreach (var client in Open.Values) client.Dispose();
                    Open.Clear();
                    return "{}";
            }
        }

        private static Contender Client(string name, string endpoint, int size)
        {
            var key = $"{name} {endpoint} {size}";
            if (!Open.TryGetValue(key, out var client)) Open[key] = client = Contender.Make(name, endpoint, size);
            return client;
        }

        private static string Echo(Contender client, double seconds)
        {
            var (messages, waits) = (0, new List<double>(1 << 16));
            var watch = Stopwatch.StartNew();
            while (watch.Elapsed.TotalSeconds < seconds) messages += client.Echo(waits);
            var took = watch.Elapsed.TotalSeconds;
            var listed = string.Join(",", waits.Select(wait => wait.ToString("F1", CultureInfo.InvariantCulture)));
            return FormattableString.Invariant(
                $"{{\"messages\":{messages},\"seconds\":{took:F6},\"waits\":[{listed}]}}");
        }

        // The player's own log, with the line "measured: …", comes before the answer.
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
