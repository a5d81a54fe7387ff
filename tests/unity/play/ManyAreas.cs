// Lesson 10's areas in a scene, each with a cart and a pole that are seen:
//
//     … play.dll areas 16 play --endpoint tcp://127.0.0.1:5560     until Python has closed the environment
//     … play.dll areas 16 warn --endpoint tcp://127.0.0.1:5560     the same, and each step of physics is warned of
//     … play.dll areas 16 switch                                   whose physics it is, as one after the other is disabled
//     … play.dll areas 16 cost 1000                                what a step of all areas costs the main thread
using System;
using System.Globalization;
using System.Linq;
using System.Runtime.InteropServices;
using System.Threading;
using UnityEngine;
using UnityPlayer;

namespace NetMQExample.PlayTest
{
    /// <summary>As a reader derives it.</summary>
    public sealed class CartPoleAreas : PythonAreas<CartPoleEnvironment> { }

    internal static class ManyAreas
    {
        public static int Run(int count, string what, string[] words)
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
                if (what != "cost") scene.SetActive(true);
            });
            if (what == "cost") Cost(worlds, int.Parse(words[0], CultureInfo.InvariantCulture));
            if (what == "warn") Physics.simulationMode = SimulationMode.FixedUpdate;
            if (what == "switch") Switch(areas, worlds);
            while (what != "cost" && what != "switch" && !(areas.Done && worlds.All(world => world.Done)) && player.Errors == 0)
            {
                player.Frame();
                Thread.Sleep(1);
            }
            player.Stop();
            return player.Errors > 0 ? 1 : 0;
        }

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

        // Without the network thread, which reads and writes the messages.
        private static void Cost(CartPoleEnvironment[] worlds, int steps)
        {
            var simulator = new AreaSimulator(worlds) { Moved = () => Physics.Simulate(0.02f) };
            Physics.simulationMode = SimulationMode.Script;
            simulator.Hello();
            var reset = new Message("reset", 1);
            reset.Arrays.Add(new MessageArray("uint8", Enumerable.Repeat((byte)1, worlds.Length).ToArray(), worlds.Length));
            reset.Arrays.Add(new MessageArray("int64", new byte[8 * worlds.Length], worlds.Length));
            simulator.Answer(reset);
            var cost = new FrameCost(steps);
            for (var id = 2; !cost.Done; id++)
            {
                var step = new Message("step", id);
                var pushes = Enumerable.Range(0, worlds.Length).Select(i => (long)((i + id) % 2)).ToArray();
                step.Arrays.Add(new MessageArray("int64", MemoryMarshal.AsBytes<long>(pushes).ToArray(), worlds.Length));
                cost.Begin();
                simulator.Answer(step);
                cost.End();
            }
            Console.WriteLine($"{worlds.Length} areas: {cost.ToString().Replace("frames", "steps")}");
        }
    }
}
