// Lesson 10's areas in a scene, each with a cart and a pole that are seen:
//
//     … play.dll areas 16 play --endpoint tcp://127.0.0.1:5560     until Python has closed the environment
//     … play.dll areas 16 warn --endpoint tcp://127.0.0.1:5560     the same, and each step of physics is warned of
//     … play.dll areas 16 switch                                   whose physics it is, as one after the other is
//                                                                  disabled
//     … play.dll areas 16 rate --endpoint tcp://127.0.0.1:5560     the same, and how fast frames may come, when that
//                                                                  changes
//     … play.dll areas 16 keep …                                   with Keep Frame Rate
//     … play.dll areas 16 set …                                    a script sets the rate while Python steps
//     … play.dll areas 16 off …                                    it is disabled while Python steps
using System;
using System.Linq;
using System.Threading;
using UnityEngine;
using UnityPlayer;

namespace NetMQExample.PlayTest
{
    /// <summary>As a reader derives it.</summary>
    public sealed class CartPoleAreas : PythonAreas<CartPoleEnvironment> { }

    internal static class ManyAreas
    {
        public static int Run(int count, string what)
        {
            var player = new Player(typeof(NetMQLifetime).Assembly);
            var worlds = new CartPoleEnvironment[count];
            CartPoleAreas areas = null;
            player.Begin(() =>
            {
                var scene = new GameObject("field");
                scene.SetActive(false);
                areas = scene.AddComponent<CartPoleAreas>();
                // It is no area, and does nothing.
                scene.AddComponent<CartPoleEnvironment>();
                for (var i = 0; i < count; i++)
                {
                    var area = new GameObject($"area {i}");
                    area.transform.SetParent(scene.transform, false);
                    worlds[i] = area.AddComponent<CartPoleEnvironment>();
                }
                if (what == "keep") Inspector.Set(new MonoBehaviour[] { areas }, "keepFrameRate", "true");
                scene.SetActive(true);
            });
            QualitySettings.vSyncCount = 2;
            Application.targetFrameRate = 30;
            if (what == "warn") Physics.simulationMode = SimulationMode.FixedUpdate;
            if (what == "switch") Switch(areas, worlds);
            var rate = "";
            while (what != "switch" && !(areas.Done && worlds.All(world => world.Done)) && player.Errors == 0)
            {
                player.Frame();
                Thread.Sleep(1);
                if (what == "warn" || what == "play" || rate == Rate) continue;
                Console.WriteLine(rate = Rate);
                if (rate != "frames: 0 -1") continue;
                if (what == "set") Application.targetFrameRate = 50;
                if (what != "off") continue;
                areas.enabled = false;
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

        // An area, which takes no physics, and then of two that do the first one.
        private static void Switch(CartPoleAreas areas, CartPoleEnvironment[] worlds)
        {
            var other = new GameObject("by hand");
            other.SetActive(false);
            Inspector.Set(new MonoBehaviour[] { other.AddComponent<CartPoleEnvironment>() }, "byHand", "true");
            other.SetActive(true);
            foreach (var one in new SteppedBehaviour[] { worlds[0], areas, other.GetComponent<CartPoleEnvironment>() })
            {
                Console.WriteLine($"physics: {Physics.simulationMode}");
                one.enabled = false;
            }
            Console.WriteLine($"physics: {Physics.simulationMode}");
        }
    }
}
