// Worlds that leave nothing to collect, and never end: whatever a frame allocates, in which Python steps them, is the
// package's own.
//
//     … play.dll quiet world --endpoint tcp://127.0.0.1:5559      what 100 frames cost; also areas, and game
using System;
using System.Collections.Generic;
using System.Threading;
using UnityEngine;
using UnityPlayer;

namespace NetMQExample.PlayTest
{
    /// <summary>Sees its last action, and a number of a part of its own.</summary>
    public sealed class QuietWorld : PythonEnvironment
    {
        private double one, two;

        public override string Name => "Quiet";

        public override GymSpace Observation { get; } =
            GymSpace.Dict(("did", GymSpace.Box(-1, 1, 2)), ("which", GymSpace.Discrete(3)));

        public override GymSpace Action { get; } = GymSpace.Box(-1, 1, 2);

        public override void ResetWorld(
            RandomGenerator random, IReadOnlyDictionary<string, object> options, double[] state) =>
            (one, two) = (0, 0);

        protected override void Act(SpaceReader action) => (one, two) = (action[0], action[1]);

        public override void Observe(SpaceWriter seen) => seen.Add(one, two, one > 0 ? 2 : 1);

        public override (double Reward, bool Terminated, bool Truncated) RewardAndEnd(IDictionary<string, object> info)
        {
            Quiet.Judged++;
            return (one, false, false);
        }
    }

    public sealed class QuietAreas : PythonAreas<QuietWorld> { }

    public sealed class QuietGame : PythonAgents
    {
        private double left, right;

        public override string Name => "Quiet";

        public override IReadOnlyList<(string Name, GymSpace Observation, GymSpace Action)> Agents { get; } = new[]
        {
            ("left", GymSpace.Box(-1, 1, 2), GymSpace.Box(-1, 1, 1)),
            ("right", GymSpace.Discrete(2), GymSpace.Discrete(2)),
        };

        public override void ResetWorld(RandomGenerator random, IReadOnlyDictionary<string, object> options) =>
            (left, right) = (0, 0);

        protected override void Act(IReadOnlyDictionary<string, SpaceReader> actions) =>
            (left, right) = (actions["left"][0], actions["right"][0]);

        public override void Observe(string agent, SpaceWriter seen)
        {
            if (agent == "left") seen.Add(left, right);
            else seen.Add(right);
        }

        public override (double Reward, bool Terminated, bool Truncated) RewardAndEnd(
            string agent, IDictionary<string, object> info)
        {
            Quiet.Judged++;
            return (left, false, false);
        }
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
                if (what == "game") scene.AddComponent<QuietGame>();
                else if (what == "areas") scene.AddComponent<QuietAreas>();
                else scene.AddComponent<QuietWorld>();
                for (var i = 0; i < 3 && what == "areas"; i++)
                {
                    var area = new GameObject($"area {i}");
                    area.transform.SetParent(scene.transform, false);
                    area.AddComponent<QuietWorld>();
                }
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
    }
}
