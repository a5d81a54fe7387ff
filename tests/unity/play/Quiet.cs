// Agents that leave nothing to collect, and never end: whatever a frame allocates, in which Python steps them, is the
// package's own.
//
//     … play.dll quiet world --endpoint tcp://127.0.0.1:5559      what 100 frames cost; also areas, and game
using System;
using System.Threading;
using UnityEngine;
using UnityPlayer;

namespace NetMQExample.PlayTest
{
    /// <summary>Sees its last action, and a number of a part of its own.</summary>
    public sealed class QuietAgent : Agent
    {
        private double one, two;

        public override GymSpace Observation { get; } =
            GymSpace.Dict(("did", GymSpace.Box(-1, 1, 2)), ("which", GymSpace.Discrete(3)));

        public override GymSpace Action { get; } = GymSpace.Box(-1, 1, 2);
        public override void OnReset() => (one, two) = (0, 0);
        public override void OnAction(SpaceReader action) => (one, two) = (action[0], action[1]);

        public override void OnStepped()
        {
            AddReward(one);
            Quiet.Judged++;
        }

        public override void Observe(SpaceWriter seen) => seen.Add(one, two, one > 0 ? 2 : 1);
    }

    /// <summary>An agent of another kind.</summary>
    public sealed class QuietSwitch : Agent
    {
        private double on;

        public override GymSpace Observation { get; } = GymSpace.Discrete(2);
        public override GymSpace Action { get; } = GymSpace.Discrete(2);
        public override void OnAction(SpaceReader action) => on = action[0];
        public override void Observe(SpaceWriter seen) => seen.Add(on);
    }

    internal static class Quiet
    {
        // How often Python has stepped.
        public static int Judged;

        public static int Run(string what)
        {
            var player = new Player(typeof(NetMQLifetime).Assembly);
            player.Begin(() =>
            {
                var scene = new GameObject("quiet");
                scene.SetActive(false);
                Inspector.Set(new MonoBehaviour[] { scene.AddComponent<GymManager>() }, "envName", "Quiet");
                for (var i = 0; i < (what == "areas" ? 3 : 1); i++) Put<QuietAgent>(scene);
                if (what == "game") Put<QuietSwitch>(scene).Name = "switch";
                scene.SetActive(true);
            });
            var cost = new FrameCost(100);
            while (!cost.Done && player.Errors == 0)
            {
                var before = Judged;
                cost.Begin();
                player.Frame();
                // A frame counts in which Python has stepped.
                if (Judged > before) cost.End();
                else if (before == 0) Thread.Sleep(1);
            }
            Console.WriteLine($"cost: {cost}");
            player.Stop();
            return player.Errors > 0 ? 1 : 0;
        }

        private static T Put<T>(GameObject scene) where T : Agent
        {
            var thing = new GameObject(typeof(T).Name);
            thing.transform.SetParent(scene.transform, false);
            return thing.AddComponent<T>();
        }
    }
}
