// Lesson 09 in Unity, the example: a pole on a cart, which Python balances. Tick By Hand, and the arrow keys do.
//
// Use: start python/09_environment/server.py, add this component to any GameObject, press Play.
using System.Collections.Generic;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>CartPole.cs in a scene.</summary>
    public sealed class CartPoleEnvironment : PythonEnvironment
    {
        private readonly CartPole world = new CartPole();

        /// <inheritdoc/>
        public override string Name => world.Name;

        /// <inheritdoc/>
        public override int StateSize => world.StateSize;

        /// <inheritdoc/>
        public override Space Observation => world.Observation;

        /// <inheritdoc/>
        public override Space Action => world.Action;

        /// <inheritdoc/>
        public override void ResetWorld(Chance chance, IReadOnlyDictionary<string, object> options, double[] state) =>
            world.ResetWorld(chance, options, state);

        /// <inheritdoc/>
        protected override void Act(double[] action) => world.Apply(action);

        /// <inheritdoc/>
        public override MessageArray Observe() => world.Observe();

        /// <inheritdoc/>
        public override (double Reward, bool Terminated, bool Truncated) Judge(IDictionary<string, object> info) =>
            world.Judge(info);

        /// <inheritdoc/>
        public override MessageArray Render() => world.Render();

        /// <inheritdoc/>
        protected override double[] Heuristic() => new[] { 0.0 };
    }
}
