// Lesson 14 as a player sees it in Unity: dotnet checks.dll jobs ENDPOINT. The test has the server.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Linq;
using System.Threading;
using UnityEngine;
using UnityPlayer;
using static NetMQExample.Tests.BackgroundClientChecks;

namespace NetMQExample.Tests
{
    internal static class JobChecks
    {
        private static readonly Player Player = new Player(typeof(NetMQLifetime).Assembly);
        private static readonly List<float> Shares = new List<float>();
        private static readonly List<string> Logged = new List<string>();
        private static JobRunner runner;
        private static JobNews end;

        public static void Run(string endpoint)
        {
            JobView view = null;
            Application.logMessageReceived += (line, stack, type) => Logged.Add(line);
            Player.Begin(() =>
            {
                var thing = new GameObject("job");
                thing.SetActive(false);
                runner = thing.AddComponent<JobRunner>();
                view = thing.AddComponent<JobView>();
                Set("endpoint", endpoint);
                Set("timeout", "20");
                Set("count", "12");
                runner.Advanced += Shares.Add;
                runner.Ended += news => end = news;
                thing.SetActive(true);
            });
            Check(!view.useGUILayout, "IMGUI's layout costs memory in each frame");
            Until(() => runner.Done);
            Check(end.Kind == "result" && end.Status == "succeeded" && end.Line == Player.Drawn, Player.Drawn);
            Check(Shares.SequenceEqual(Shares.OrderBy(share => share)) && Shares[^1] == 1, string.Join(" ", Shares));
            Check(Logged.Any(line => line.StartsWith("done: succeeded, 432 bytes, sum ", StringComparison.Ordinal)),
                Logged[^1]);
            // Unity's textures have the lowest row first.
            var rows = Enumerable.Range(0, 12).Reverse().SelectMany(row => end.Finished.Slice(row * 36, 36).ToArray());
            Check(end.Side == 12 && rows.SequenceEqual(end.Pixels), "the rows");
            Check(Player.Picture is Texture2D { width: 12 }, "the picture is drawn");
            Textures(1);

            // A larger picture takes the place of the first one, and its frames leave nothing to collect; and the
            // button.
            runner.enabled = false;
            Set("count", "200");
            runner.enabled = true;
            var cost = new FrameCost(100);
            Until(() => cost.Done, cost);
            Console.WriteLine($"cost: {cost}");
            runner.Cancel();
            Until(() => runner.Done);
            Check(end.Status == "canceled" && end.Side == 200 && end.Line == Player.Drawn, end.Line);
            Textures(1);
            Player.Stop();
            Textures(0);
            Check(Player.Errors == 0, string.Join("\n", Logged));
        }

        private static void Set(string name, string value) =>
            Inspector.Set(new MonoBehaviour[] { runner }, name, value);

        private static void Textures(int count)
        {
            Player.Frame();
            var left = Player.Left.Count(name => name == "Texture2D");
            Check(left == count, $"{left} textures in place of {count}");
        }

        private static void Until(Func<bool> condition, FrameCost cost = null)
        {
            for (var waited = Stopwatch.StartNew(); !condition(); Thread.Sleep(5))
            {
                Check(waited.Elapsed < TimeSpan.FromSeconds(100), $"took too long: {string.Join("\n", Logged)}");
                var before = Logged.Count;
                cost?.Begin();
                Player.Frame();
                // A frame in which a line is logged does not count: the line itself is memory.
                if (Logged.Count == before) cost?.End();
            }
        }
    }
}
