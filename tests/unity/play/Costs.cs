// Measures so many frames of a lesson's scripts on the main thread, at 60 frames a second:
//
//     dotnet play.dll cost 14 300 endpoint=tcp://127.0.0.1:5564 …        the lesson, frames, and the serialized fields
//     dotnet play.dll cost 14 300 "after= of " …                         not before a line with this was logged
//
// A frame in which a line is logged does not count: the line itself is memory.
using System;
using System.Diagnostics;
using System.Globalization;
using System.Linq;
using System.Threading;
using UnityEngine;
using UnityPlayer;

namespace NetMQExample.PlayTest
{
    internal static class Costs
    {
        public static int Run(string lesson, string frames, string[] settings)
        {
            var lessons = typeof(NetMQLifetime).Assembly;
            var player = new Player(lessons);
            var logged = false;
            var under = !settings[0].StartsWith("after=", StringComparison.Ordinal);
            Application.logMessageReceived += (line, stack, type) =>
            {
                logged = true;
                under = under || line.Contains(settings[0].Substring(6));
            };
            player.Begin(() =>
            {
                var thing = new GameObject("lesson");
                thing.SetActive(false);
                var scripts = Scripts.Of(lessons, lesson).Select(type => (MonoBehaviour)(thing.GetComponent(type) ?? thing.AddComponent(type))).ToArray();
                foreach (var pair in settings.Where(word => !word.StartsWith("after=", StringComparison.Ordinal)).Select(word => word.Split(new[] { '=' }, 2))) Inspector.Set(scripts, pair[0], pair[1]);
                thing.SetActive(true);
            });
            var cost = new FrameCost(int.Parse(frames, CultureInfo.InvariantCulture));
            var clock = Stopwatch.StartNew();
            for (long frame = 1; !cost.Done; frame++)
            {
                logged = false;
                cost.Begin();
                player.Frame();
                if (under && !logged) cost.End();
                var rest = TimeSpan.FromSeconds(frame / 60.0) - clock.Elapsed;
                if (rest > TimeSpan.Zero) Thread.Sleep(rest);
            }
            Console.WriteLine($"cost: {cost}");
            player.Stop();
            return player.Errors > 0 ? 1 : 0;
        }
    }
}
