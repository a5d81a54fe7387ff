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
            Debug.Log("by hand: Heuristic plays, without Python; each episode's return follows");
        }

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
                BeginAll();
                begun = true;
            }
            var (reward, over) = Step();
            steps++;
            total += reward;
            if (!over) return;
            Debug.Log(FormattableString.Invariant($"by hand: {steps} steps, return {total:F1}"));
            steps = 0;
            total = 0;
            seed++;
            BeginAll();
        }

        private void BeginAll()
        {
            foreach (var kind in simulator.Roster.Kinds) kind.Asked = true;
            foreach (var row in simulator.Roster.Rows) (row.Order, row.Seed) = (Order.Reset, seed + row.Number);
            SceneSimulator.Inside(() => simulator.Moves.Begin(row => true, default, seed));
        }

        // The rewards of all, and whether all are over.
        private (double Reward, bool Over) Step()
        {
            var rows = simulator.Roster.Rows;
            simulator.Roster.Settle(false);
            foreach (var row in rows)
            {
                row.Order = Order.Step;
                if (row.Lives) row.Take(heuristic(row.Agent));
            }
            SceneSimulator.Inside(() =>
            {
                simulator.Moves.Step();
                simulator.Moves.Begin(row => false, default, 0);
            });
            var reward = 0.0;
            foreach (var row in rows)
            {
                row.Told |= !row.Present;
                if (!row.Present) continue;
                reward += row.State.Take().Reward;
                // Nobody reads them.
                row.State.TakeInfo();
                row.State.ForgetInfo();
            }
            return (reward, !rows.Exists(row => row.Lives));
        }
    }
}
