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
    public sealed class PursuitGame : GymManager
    {
        private readonly Pursuit world = new Pursuit();
        private Transform[] cubes;

        /// <inheritdoc/>
        protected override string EnvName => "Pursuit";

        /// <inheritdoc/>
        protected override double Dt => 0.1;

        /// <inheritdoc/>
        protected override IReadOnlyList<IAgent> Agents => world.Players;

        /// <inheritdoc/>
        public override void OnReset(RandomGenerator random, IReadOnlyDictionary<string, object> options) =>
            world.OnReset(random, options);

        /// <inheritdoc/>
        public override void OnTick(double dt) => world.OnTick(dt);

        /// <inheritdoc/>
        public override MessageArray Render() => world.Render();

        /// <inheritdoc/>
        protected override object Heuristic(IAgent agent)
        {
            var (x, y) = (ArrowKeys.Horizontal, ArrowKeys.Vertical);
            // The others rest: alone one wins slowly.
            if (agent != world.Players[0] || (x == 0 && y == 0)) return 0L;
            return x != 0 ? x < 0 ? 1L : 2L : y < 0 ? 3L : 4L;
        }

        private void Awake()
        {
            world.SendInfo = SendInfo;
            // Hunters are the taller ones.
            cubes = world.Players
                .Select(player => Cube.Make(new Vector3(0.3f, player.Hunts ? 0.6f : 0.3f, 0.3f))).ToArray();
        }

        private void LateUpdate()
        {
            for (var i = 0; i < cubes.Length; i++)
            {
                var player = world.Players[i];
                // An agent that is out is higher than the camera, which looks down. The world is 8 m wide.
                cubes[i].position = new Vector3((float)(4 * player.X), player.Lives ? 0 : 20, (float)(4 * player.Y));
            }
        }
    }
}
