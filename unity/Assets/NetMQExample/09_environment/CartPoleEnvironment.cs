// Lesson 09 in Unity, the example: a pole on a cart, which Python balances. Tick By Hand, and the arrow keys do.
//
// Use: start python/09_environment/server.py, add this component to any GameObject, press Play.
using System;
using System.Collections.Generic;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>CartPole.cs in a scene, with a cart and a pole made of cubes.</summary>
    [AddComponentMenu("NetMQ Example/09 Cart Pole Environment")]
    public sealed class CartPoleEnvironment : PythonEnvironment
    {
        private readonly CartPole world = new CartPole();
        private Transform cart, pole;

        /// <inheritdoc/>
        public override string Name => world.Name;

        /// <inheritdoc/>
        public override int StateSize => world.StateSize;

        /// <inheritdoc/>
        public override GymSpace Observation => world.Observation;

        /// <inheritdoc/>
        public override GymSpace Action => world.Action;

        /// <inheritdoc/>
        public override void ResetWorld(
            RandomGenerator random, IReadOnlyDictionary<string, object> options, double[] state) =>
            world.ResetWorld(random, options, state);

        /// <inheritdoc/>
        protected override void Act(SpaceReader action) => world.Apply(action);

        /// <inheritdoc/>
        public override void Observe(SpaceWriter seen) => world.Observe(seen);

        /// <inheritdoc/>
        public override (double Reward, bool Terminated, bool Truncated) RewardAndEnd(
            IDictionary<string, object> info) =>
            world.RewardAndEnd(info);

        /// <inheritdoc/>
        public override MessageArray Render() => world.Render();

        /// <inheritdoc/>
        protected override double[] Heuristic() =>
            // There is no third way: whoever does not push to the right pushes to the left.
            new[] { ArrowKeys.Horizontal > 0 ? 1.0 : 0.0 };

        private void Awake()
        {
            cart = Cube.Make(new Vector3(0.8f, 0.5f, 0.5f));
            pole = Cube.Make(new Vector3(0.1f, 2, 0.1f));
            Cube.Make(new Vector3(5, 0.05f, 0.1f));
        }

        private void LateUpdate()
        {
            cart.position = new Vector3((float)world.Place, 0, 0);
            var along = new Vector3((float)Math.Sin(world.Angle), (float)Math.Cos(world.Angle), 0);
            var turn = Quaternion.Euler(0, 0, (float)(-world.Angle * 180 / Math.PI));
            pole.SetPositionAndRotation(cart.position + along, turn);
        }
    }
}
