// Lesson 10 in Unity, the example: hunters and rabbits as cubes. Tick By Hand, and the arrow keys drive hunter_0.
//
// Use: start python/10_many_agents/server.py, add this component to any GameObject, press Play.
using System.Collections.Generic;
using System.Linq;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Pursuit.cs in a scene.</summary>
    [AddComponentMenu("NetMQ Example/10 Pursuit Game")]
    public sealed class PursuitGame : PythonAgents
    {
        private readonly Pursuit world = new Pursuit();
        private readonly Dictionary<string, Transform> cubes = new Dictionary<string, Transform>();

        /// <inheritdoc/>
        public override string Name => world.Name;

        /// <inheritdoc/>
        public override double Dt => world.Dt;

        /// <inheritdoc/>
        public override IReadOnlyList<(string Name, GymSpace Observation, GymSpace Action)> Agents => world.Agents;

        /// <inheritdoc/>
        public override InfoQueue Infos => world.Infos;

        /// <inheritdoc/>
        public override void ResetWorld(RandomGenerator random, IReadOnlyDictionary<string, object> options) =>
            world.ResetWorld(random, options);

        /// <inheritdoc/>
        protected override void Act(IReadOnlyDictionary<string, SpaceReader> actions) => world.Apply(actions);

        /// <inheritdoc/>
        public override void Observe(string agent, SpaceWriter seen) => world.Observe(agent, seen);

        /// <inheritdoc/>
        public override (double Reward, bool Terminated, bool Truncated) RewardAndEnd(
            string agent, IDictionary<string, object> info) => world.RewardAndEnd(agent, info);

        /// <inheritdoc/>
        public override MessageArray Render() => world.Render();

        /// <inheritdoc/>
        protected override double[] Heuristic(string agent)
        {
            // The others rest: alone one wins slowly.
            var way = 0.0;
            var (x, y) = (ArrowKeys.Horizontal, ArrowKeys.Vertical);
            if (agent == "hunter_0" && x != 0) way = x < 0 ? 1 : 2;
            else if (agent == "hunter_0" && y != 0) way = y < 0 ? 3 : 4;
            return new[] { way };
        }

        private void Awake()
        {
            foreach (var name in world.Agents.Select(agent => agent.Name))
                // Hunters are the taller ones.
                cubes[name] = Cube.Make(new Vector3(0.3f, name[0] == 'h' ? 0.6f : 0.3f, 0.3f));
        }

        private void LateUpdate()
        {
            foreach (var cube in cubes)
            {
                var (x, y, lives) = world.Place(cube.Key);
                // An agent that is out is higher than the camera, which looks down. The world is 8 m wide.
                cube.Value.position = new Vector3((float)(4 * x), lives ? 0 : 20, (float)(4 * y));
            }
        }
    }
}
