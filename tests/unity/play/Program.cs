// Presses Play and Stop. The test says when, by lines on the standard input: play, destroy, stop, …
//
//     mono play.dll reload                               each Play in a fresh AppDomain
//     … play.dll keep                                    every Play on the same statics, as with domain reload off
//     … play.dll flood 1 tcp://127.0.0.1:5551 150        a Play in which each line of the log costs 0.3 ms
//     … play.dll wrong 4 tries 0 …                       Plays of ten frames, each with a field that is wrong
//     … play.dll views front front                     a Play of lesson 12 with cameras of these names
//     … play.dll forgotten                               no Play: a socket is not disposed, and the process ends
//
// The other words are those of the files that Main calls.
// "play 1 tcp://127.0.0.1:5551 2" has two of lesson 1's clients in the scene. It prints "ready", "playing", what the
// scripts log, "stopped in 12.3 ms" and, after a reload, "unloaded in 45.6 ms". Threads and sockets are counted by the
// test, from outside.
using System;
using System.Collections.Concurrent;
using System.Collections.Generic;
using System.Diagnostics;
using System.Globalization;
using System.Linq;
using System.Runtime.CompilerServices;
using System.Threading;
using UnityEngine;
using UnityPlayer;
using Object = UnityEngine.Object;

namespace NetMQExample.PlayTest
{
    internal static class Program
    {
        private const string Asked = "asked";
        private static readonly string Self = typeof(Program).Assembly.Location;
        private static volatile AppDomain domain = AppDomain.CurrentDomain;

        private static int Main(string[] words)
        {
            // Mono 6.8: when two threads make the first writers of a program at the same moment, one may lack its line
            // end.
            _ = Console.Out;
            switch (words[0])
            {
                case "editor": return EditorTest.EditorProgram.Run();
                case "habits": return Habits.Print();
                case "first": return FirstScripts.Play(words[1]);
                case "keys": return Keys.Print();
                case "clock": return MLAgentsWorlds.Worlds.Run(words.Skip(1).ToArray());
                case "areas": return ManyAreas.Run(int.Parse(words[1], CultureInfo.InvariantCulture), words[2]);
                case "quiet": return Quiet.Run(words[1]);
                case "cameras": return Cameras.Run();
                case "pictures": return PictureCost.Run(words[1]);
                case "touches": return Touches.Run();
                case "mlsensors": return MlTest.MlSensors.Run();
                case "mlscene": return MlScene.Run(words[1]);
                case "drive": return Drives.Run(words.Skip(1).ToArray());
                case "body": return Bodies.Run(words.Skip(1).ToArray());
                case "views": return Views(words.Skip(1).ToArray());
                case "forgotten": return Forget();
                case "flood": return Flood(words[1], words[2], int.Parse(words[3], CultureInfo.InvariantCulture));
                case "wrong": return Wrong(words);
                case "play": return Play(words[1], words[2], int.Parse(words[3], CultureInfo.InvariantCulture));
            }
            using var plays = new BlockingCollection<string>();
            new Thread(() => Listen(plays)) { IsBackground = true }.Start();
            Console.WriteLine("ready");
            foreach (var play in plays.GetConsumingEnumerable())
            {
                if (words[0] == "keep") Main(Words(play));
                else PlayInDomain(Words(play));
                Console.WriteLine("ready");
            }
            return 0;
        }

        // It stays outside the domain of the Play: a thread that waits for input would hold up the unloading.
        private static void Listen(BlockingCollection<string> plays)
        {
            for (var line = Console.ReadLine(); line != null && line != "end"; line = Console.ReadLine())
            {
                if (line.StartsWith("play ", StringComparison.Ordinal)
                    || line.StartsWith("clock|", StringComparison.Ordinal)) plays.Add(line);
                else Tell(line);
            }
            plays.CompleteAdding();
        }

        // An agent of MLAgentsWorlds.cs is a word with blanks.
        private static string[] Words(string play) =>
            play.Split(play.StartsWith("clock|", StringComparison.Ordinal) ? '|' : ' ');

        private static void Tell(string line)
        {
            try { domain.SetData(Asked, line); }
            // The domain is done and unloaded before this thread had a core to return on.
            catch (AppDomainUnloadedException) { }
        }

        private static int Play(string script, string endpoint, int clients)
        {
            var here = AppDomain.CurrentDomain;
            var own = typeof(Program).Assembly;
            var lessons = typeof(NetMQLifetime).Assembly;
            var named = own.GetType($"NetMQExample.PlayTest.{script}");
            var types = named == null ? Scripts.Of(lessons, script) : new[] { named };
            var player = new Player(lessons);
            GameObject first = null;
            var all = new List<GameObject>();
            player.Begin(() =>
            {
                for (var i = clients; i > 0; i--)
                    all.Add(first = MakeObject($"client {i}", types, endpoint, int.MaxValue));
            });
            Console.WriteLine("playing");
            var frozen = false;
            for (var asked = ""; asked != "stop"; asked = (string)here.GetData(Asked) ?? "")
            {
                if (asked.Length > 0) here.SetData(Asked, null);
                var busy = Stopwatch.StartNew();
                if (asked == "destroy") Object.Destroy(first);
                if (asked == "destroy all") all.ForEach(Object.Destroy);
                if (asked == "off" || asked == "on") first.SetActive(asked == "on");
                if (asked == "recompile") Say("recompiled", player.Recompile());
                if (asked == "pause" || asked == "resume")
                {
                    Application.Mobile = true;
                    player.Pause(asked == "pause");
                    Console.WriteLine($"{asked}d");
                }
                frozen = frozen || asked == "freeze";
                if (!frozen) player.Frame();
                if (asked == "freeze") Console.WriteLine("frozen");
                if (asked == "destroy") Console.WriteLine("destroyed");
                if (asked == "off" || asked == "on") Console.WriteLine($"switched {asked}");
                if (asked == "destroy all") Say("destroyed", busy.Elapsed);
                Thread.Sleep(5);
            }
            Application.Mobile = false;
            here.SetData(Asked, null);
            Say("stopped", player.Stop());
            Console.WriteLine($"left: {string.Join(" ", Player.Left)}");
            return 0;
        }

        private static int Forget()
        {
            ForgetfulClient.Forget("tcp://127.0.0.1:9");
            // It listens to the end of its domain, as NetMQLifetime does.
            RuntimeHelpers.RunClassConstructor(typeof(DotNetConnection).TypeHandle);
            Console.WriteLine("forgotten");
            return 0;
        }

        // How many lines at most one frame has logged, which no load of the machine can make more.
        private static int Flood(string script, string endpoint, int count)
        {
            var lessons = typeof(NetMQLifetime).Assembly;
            var player = new Player(lessons);
            int lines = 0, before = 0, most = 0, frames = 0;
            Application.logMessageReceived += (line, stack, type) => lines++;
            player.Begin(() => MakeObject("flood", Scripts.Of(lessons, script), endpoint, count));
            // Not FromMilliseconds: Mono makes that a whole number.
            UnityEngine.Debug.Cost = TimeSpan.FromTicks(3000);
            for (; !player.Done; frames++)
            {
                player.Frame();
                (most, before) = (Math.Max(most, lines - before), lines);
            }
            UnityEngine.Debug.Cost = TimeSpan.Zero;
            player.Stop();
            Console.WriteLine($"{lines} lines in {frames} frames, at most {most} in one");
            return 0;
        }

        private static int Wrong(string[] words)
        {
            var lessons = typeof(NetMQLifetime).Assembly;
            for (var at = 1; at < words.Length; at += 3)
            {
                var (script, name, value) = (words[at], words[at + 1], words[at + 2]);
                var player = new Player(lessons);
                player.Begin(() =>
                {
                    var thing = MakeObject("wrong", Scripts.Of(lessons, script), "tcp://127.0.0.1:9", 3, false);
                    Console.WriteLine($"done before it was enabled: {player.Done}");
                    foreach (var part in Scripts.Of(lessons, script).Select(type => thing.GetComponent(type)))
                        foreach (var field in Inspector.Fields(part.GetType()).Where(field => field.Name == name))
                            field.SetValue(part,
                                Convert.ChangeType(value, field.FieldType, CultureInfo.InvariantCulture));
                    thing.SetActive(true);
                });
                UntilDone(player);
            }
            return 0;
        }

        private static int Views(string[] names)
        {
            var player = new Player(typeof(NetMQLifetime).Assembly);
            player.Begin(() =>
            {
                var thing = new GameObject("views");
                thing.SetActive(false);
                var recorder = thing.AddComponent<ViewRecorder>();
                recorder.Cameras.AddRange(names.Select(name => new GameObject(name).AddComponent<Camera>()));
                thing.SetActive(true);
            });
            return UntilDone(player);
        }

        private static int UntilDone(Player player)
        {
            for (var i = 0; i < 10 || (!player.Done && i < 1000); i++)
            {
                player.Frame();
                Thread.Sleep(5);
            }
            player.Stop();
            Console.WriteLine($"errors: {player.Errors}");
            return 0;
        }

        private static GameObject MakeObject(string name, Type[] types, string endpoint, int count, bool on = true)
        {
            var thing = new GameObject(name);
            thing.SetActive(false);
            foreach (var script in Scripts.AddTo(thing, types))
            {
                var asksAgain = Inspector.Fields(script.GetType()).Any(field => field.Name == "tries");
                foreach (var field in Inspector.Fields(script.GetType()))
                {
                    if (field.GetValue(script) is string text && text.Contains("://127.0.0.1:"))
                        field.SetValue(script, endpoint);
                    // A job that lasts as long as the others.
                    if (script is JobRunner && field.Name == "kind") field.SetValue(script, "count");
                    // A client that asks once gives up at the first reply that is late, which is no question here.
                    if (field.Name == "timeout" && field.GetValue(script) is float timeout && !asksAgain)
                        field.SetValue(script, Math.Max(timeout, 20f));
                    // As a rule so many that it is still asking when Stop comes.
                    if (field.Name == "count")
                        field.SetValue(script,
                            script is JobRunner
                                ? Math.Min(count, 2000)
                                : script is TalkingCharacter ? Math.Min(count, 200) : count);
                }
            }
            thing.SetActive(on);
            return thing;
        }

        private static void PlayInDomain(string[] inside)
        {
            domain = AppDomain.CreateDomain("Play");
            domain.ExecuteAssembly(Self, inside);
            var busy = Stopwatch.StartNew();
            AppDomain.Unload(domain);
            Say("unloaded", busy.Elapsed);
        }

        private static void Say(string what, TimeSpan time) =>
            Console.WriteLine(FormattableString.Invariant($"{what} in {time.TotalMilliseconds:F1} ms"));
    }
}
