// Many agents in a scene, each a cart and a pole that are seen:
//
//     … play.dll areas 16 play --endpoint tcp://127.0.0.1:5559     until Python has closed the environment
//     … play.dll areas 16 warn --endpoint tcp://127.0.0.1:5559     the same, and each step of physics is warned of
//     … play.dll areas 16 switch                                   whose physics it is, as one after the other is
//                                                                  disabled
//     … play.dll areas 16 rate --endpoint tcp://127.0.0.1:5559     the same, and how fast frames may come, when that
//                                                                  changes
//     … play.dll areas 16 keep …                                   with Keep Frame Rate
//     … play.dll areas 16 set …                                    a script sets the rate while Python steps
//     … play.dll areas 16 off …                                    it is disabled while Python steps
using System;
using System.Threading;
using UnityEngine;
using UnityPlayer;

namespace NetMQExample.PlayTest
{
    internal static class ManyAreas
    {
        public static int Run(int count, string what)
        {
            var player = new Player(typeof(NetMQLifetime).Assembly);
            GymManager manager = null;
            player.Begin(() =>
            {
                var scene = new GameObject("field");
                scene.SetActive(false);
                manager = scene.AddComponent<GymManager>();
                for (var i = 0; i < count; i++)
                {
                    var area = new GameObject($"area {i}");
                    area.transform.SetParent(scene.transform, false);
                    area.AddComponent<CartPoleAgent>();
                }
                if (what == "keep") Inspector.Set(new MonoBehaviour[] { manager }, "keepFrameRate", "true");
                scene.SetActive(true);
            });
            QualitySettings.vSyncCount = 2;
            Application.targetFrameRate = 30;
            if (what == "warn") Physics.simulationMode = SimulationMode.FixedUpdate;
            if (what == "switch") Switch(manager);
            var rate = "";
            while (what != "switch" && !manager.Done && player.Errors == 0)
            {
                player.Frame();
                Thread.Sleep(1);
                if (what == "warn" || what == "play" || rate == Rate) continue;
                Console.WriteLine(rate = Rate);
                if (rate != "frames: 0 -1") continue;
                if (what == "set") Application.targetFrameRate = 50;
                if (what != "off") continue;
                manager.enabled = false;
                break;
            }
            // Its thread may end between two frames.
            player.Frame();
            if (rate.Length > 0 && rate != Rate) Console.WriteLine(Rate);
            player.Stop();
            return player.Errors > 0 ? 1 : 0;
        }

        private static string Rate =>
            FormattableString.Invariant($"frames: {QualitySettings.vSyncCount} {Application.targetFrameRate}");

        private static void Switch(GymManager manager)
        {
            var other = new GameObject("member").AddComponent<FleetMember>();
            foreach (var one in new SteppedBehaviour[] { manager, other })
            {
                Console.WriteLine($"physics: {Physics.simulationMode}");
                one.enabled = false;
            }
            Console.WriteLine($"physics: {Physics.simulationMode}");
        }
    }
}
