// Runs a lesson's MonoBehaviours in the player: dotnet run --project csharp-console -- NN --unity.
// In place of NN `kit.py play` gives the DLL that it has built of a reader's own scripts.
//
//     --count 3           a serialized field, as in the inspector; --help says which there are
//     --set count=3       the same
//     --MyClient.count 3  that of one class, whatever the others have
//     --seconds 5         stop then; without it, once every script with a Done property is done
//     --click Send        somebody clicks this button, a second later; Volume=0.5 moves a slider; each further one
//                         a second after
//     --add LineRenderer  the object has this component, too: one of Unity's, or of the kit's
//     -batchmode          and -nographics and -logFile F: Unity's own switches change nothing here
//
// The scene is one game object with every MonoBehaviour of the lesson's folder, as in the lesson's Unity scene, or of
// the DLL.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Reflection;
using System.Runtime.InteropServices;
using System.Threading;
using UnityEngine;
using UnityPlayer;

namespace NetMQExample.Terminal
{
    internal static class Play
    {
        private static readonly TimeSpan Grace = TimeSpan.FromSeconds(10), Goodbye = TimeSpan.FromSeconds(5),
            Frame = TimeSpan.FromSeconds(2);
        private static readonly string Frozen =
            $"a script has held the main thread for {Grace.TotalSeconds} s, in Update or at Stop: "
            + "Unity's editor would be frozen now";
        // Nobody waits for it: it comes up only if something else keeps the process.
        private static readonly Timer Left = new(_ => GiveUp(
            $"a thread of a script still runs {Goodbye.TotalSeconds} s after Stop: in Unity's editor it "
            + "would go on until the editor is closed. Let its loop end in OnDisable, and set its IsBackground"));

        /// <summary>Without those of Unity's own switches that have no meaning here.</summary>
        public static IEnumerable<string> WithoutUnitysOwn(string[] words)
        {
            bool Is(int i, params string[] names) =>
                i >= 0 && names.Contains(words[i], StringComparer.OrdinalIgnoreCase);
            return words.Where((word, i) => !Is(i, "-batchmode", "-nographics", "-logFile") && !Is(i - 1, "-logFile"));
        }

        public static int Run(string? lesson, Arguments arguments)
        {
            arguments.Flag("unity");
            var lessons = typeof(NetMQLifetime).Assembly;
            var own = lesson?.EndsWith(".dll", StringComparison.Ordinal) == true
                ? Assembly.LoadFrom(Path.GetFullPath(lesson))
                : null;
            var types = own == null ? Scripts.Of(lessons, lesson ?? "") : Scripts.Of(own, lessons);
            var fields = types.SelectMany(Inspector.Defaults).ToList();
            // A script that has such a field itself ends by itself then.
            var ends = fields.Any(field => field.Name == "seconds");
            var untilDone = ends || !arguments.Has("seconds");
            var limit = ends ? TimeSpan.FromDays(1) : arguments.Seconds("seconds", 86400);
            // The academy of ML-Agents' agents reads both itself, and their scripts have no such field.
            arguments.Text("mlagents-port", "");
            if (fields.All(field => field.Name != "endpoint") && types.Any(typeof(MLAgents.Agent).IsAssignableFrom))
                arguments.Text("endpoint", "");
            var settings = All(arguments, "set").Select(Setting).ToList();
            var clicks = All(arguments, "click");
            var added = All(arguments, "add")
                .Select(name => Inspector.Component(name, own ?? lessons, lessons)).ToArray();
            settings.AddRange(arguments.TakeTheRest());
            // Only for --help, and for what does not begin with --.
            foreach (var (name, value) in fields) arguments.Text(name, value);
            arguments.RefuseTheRest();

            var stopped = 0;
            // A main thread that waits for Python, or for ever, hears of no signal.
            using var late = new Timer(_ =>
            {
                Console.Error.WriteLine("stopped");
                Environment.Exit(1);
            });
            void Stop(PosixSignalContext signal)
            {
                // Not the end of the process: the Play ends as with the Stop button.
                signal.Cancel = true;
                Interlocked.Exchange(ref stopped, 1);
                late.Change(Frame, Timeout.InfiniteTimeSpan);
            }
            using var interrupt = PosixSignalRegistration.Create(PosixSignal.SIGINT, Stop);
            using var terminate = PosixSignalRegistration.Create(PosixSignal.SIGTERM, Stop);

            using var frozen = new Timer(_ => GiveUp(Frozen), null, limit + Grace, Timeout.InfiniteTimeSpan);
            var player = own == null ? new Player(lessons) : new Player(lessons, own);
            try
            {
                foreach (var click in clicks) player.Clicks.Enqueue(click);
                player.Begin(() => MakeScene(types, added, settings));
                player.Run(limit, () => Volatile.Read(ref stopped) == 1, untilDone);
            }
            finally
            {
                late.Change(Timeout.Infinite, Timeout.Infinite);
                frozen.Change(Grace, Timeout.InfiniteTimeSpan);
                player.Stop();
                // A lesson's leaves none.
                if (own != null) Left.Change(Goodbye, Timeout.InfiniteTimeSpan);
            }
            if (stopped == 1) Console.Error.WriteLine("stopped");
            return stopped == 1 || player.Errors > 0 ? 1 : 0;
        }

        // A script that freezes Unity's editor would keep a terminal waiting without a word.
        private static void GiveUp(string why)
        {
            Console.Error.WriteLine($"gave up: {why}");
            Environment.Exit(1);
        }

        private static List<string> All(Arguments arguments, string name)
        {
            var all = new List<string>();
            while (arguments.Has(name)) all.Add(arguments.Text(name, ""));
            return all;
        }

        private static void MakeScene(Type[] types, Type[] added, List<(string Name, string Value)> settings)
        {
            var thing = new GameObject(types[0].Name);
            // Components wake up when their object is switched on: the fields are set by then, as in a scene file.
            thing.SetActive(false);
            Scripts.AddTo(thing, added.Concat(types));
            // The fields of one that another has brought along count as well.
            var scripts = thing.GetComponents<MonoBehaviour>();
            foreach (var script in scripts) Inspector.FillIn(script);
            // A setting of one class comes after those of all classes, and so counts more.
            foreach (var (name, value) in settings.OrderBy(one => one.Name.Contains('.')))
                Inspector.Set(scripts, name, value);
            thing.SetActive(true);
        }

        private static (string Name, string Value) Setting(string text)
        {
            var equals = text.IndexOf('=');
            return equals > 0
                ? (text[..equals], text[(equals + 1)..])
                : throw new UsageException(
                    $"--set takes name=value, such as endpoint=tcp://127.0.0.1:5551, not '{text}'");
        }
    }
}
