// Lesson 09 in Unity: a scene that a person plays, by the clock and without Python.
using System;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Steps all agents with what Heuristic says, and says what each episode has brought.</summary>
    internal sealed class ByHand
    {
        private readonly SceneSimulator simulator;
        private readonly Func<IAgent, object> heuristic;
        private readonly double dt;
        private long seed;
        private int steps;
        private double total, since;
        private bool begun;

        public ByHand(SceneSimulator simulator, double dt, Func<IAgent, object> heuristic)
        {
            this.simulator = simulator;
            this.dt = dt;
            this.heuristic = heuristic;
        }

        public void Begin() => Debug.Log("by hand: Heuristic plays, without Python; each episode's return follows");

        /// <summary>Goes on by the clock.</summary>
        public void Tick(double seconds)
        {
            since += seconds;
            // At the speed of the world. As floats both are not quite what they are called.
            if (since < dt - 0.001) return;
            since = 0;
            if (!begun)
            {
                // Not before all agents of the scene are there.
                simulator.Describe();
                simulator.BeginByHand(seed);
                begun = true;
            }
            var (reward, over) = simulator.StepByHand(heuristic);
            steps++;
            total += reward;
            if (!over) return;
            Debug.Log(FormattableString.Invariant($"by hand: {steps} steps, return {total:F1}"));
            steps = 0;
            total = 0;
            simulator.BeginByHand(++seed);
        }
    }
}
