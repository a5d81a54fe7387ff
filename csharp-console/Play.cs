// Runs a lesson's MonoBehaviours in the player: dotnet run --project csharp-console -- NN --unity.
//
//     --set endpoint=tcp://127.0.0.1:5600     a serialized field, as in the inspector; as often as needed
//     --seconds 5                             stop then; without it, once every script with a Done property is done
//
// The scene is one game object with every MonoBehaviour of the lesson's folder, as in the lesson's Unity scene.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Runtime.InteropServices;
using System.Threading;
using UnityEngine;
using UnityPlayer;

namespace NetMQExample.Terminal
{
    internal static class Play
    {
        public static int Run(string? lesson, Arguments arguments)
        {
            arguments.Flag("unity");
            var limit = arguments.Seconds("seconds", 86400);
            var settings = new List<string>();
            for (var set = arguments.Text("set", ""); set.Length > 0; set = arguments.Text("set", "")) settings.Add(set);
            arguments.RefuseTheRest();

            var scripts = typeof(NetMQLifetime).Assembly;
            var types = Scripts.Of(scripts, lesson ?? "");
            var stopped = 0;
            void Stop(PosixSignalContext signal)
            {
                // Not the end of the process: the Play ends as with the Stop button.
                signal.Cancel = true;
                Interlocked.Exchange(ref stopped, 1);
            }
            using var interrupt = PosixSignalRegistration.Create(PosixSignal.SIGINT, Stop);
            using var terminate = PosixSignalRegistration.Create(PosixSignal.SIGTERM, Stop);

            var player = new Player(scripts);
            try
            {
                player.Begin(() => MakeScene(types, settings));
                player.Run(limit, () => Volatile.Read(ref stopped) == 1);
            }
            finally
            {
                player.Stop();
            }
            if (stopped == 1) Console.Error.WriteLine("stopped");
            return stopped == 1 || player.Errors > 0 ? 1 : 0;
        }

        private static void MakeScene(Type[] types, List<string> settings)
        {
            var thing = new GameObject(types[0].Name);
            // Components wake up when their object is switched on: the fields are set by then, as in a scene file.
            thing.SetActive(false);
            var scripts = types.Select(type => (MonoBehaviour)thing.AddComponent(type)).ToArray();
            foreach (var setting in settings)
            {
                var equals = setting.IndexOf('=');
                if (equals < 1) throw new UsageException($"--set takes name=value, such as endpoint=tcp://127.0.0.1:5551, not '{setting}'");
                Inspector.Set(scripts, setting[..equals], setting[(equals + 1)..]);
            }
            thing.SetActive(true);
        }
    }
}
