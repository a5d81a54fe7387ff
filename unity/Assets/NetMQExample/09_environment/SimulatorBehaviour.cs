// Lesson 09 in Unity: a scene that Python steps, and that a person can play by hand instead, without Python.
//
// PythonEnvironment is one, for one world. How it goes with physics and frames, see SteppedBehaviour.cs.
using System;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Asked by Python to step, or played by hand.</summary>
    public abstract class SimulatorBehaviour : SteppedBehaviour
    {
        [SerializeField, Tooltip("Play with Heuristic, without Python; from the next Play on")] private bool byHand;

        // As it was when this began: whoever ticks it meanwhile has to disable and enable the component.
        private bool played;
        private long seed;
        private int steps;
        private double total, since;

        /// <summary>How many seconds one step takes.</summary>
        public virtual double Dt => 0.02;

        /// <inheritdoc/>
        protected override bool Connects => !played;

        /// <summary>Begins an episode that is played by hand.</summary>
        protected abstract void ResetByHand(RandomGenerator random);

        /// <summary>One step by hand.</summary>
        /// <returns>The step's reward, and whether the episode is over.</returns>
        protected abstract (double Reward, bool Over) StepByHand();

        /// <inheritdoc/>
        protected override void Begin()
        {
            played = byHand;
            base.Begin();
            if (!played) return;
            Debug.Log("by hand: Heuristic plays, without Python; each episode's return follows");
            ResetByHand(new RandomGenerator(seed));
        }

        /// <summary>Plays by hand.</summary>
        protected virtual void FixedUpdate()
        {
            since += Time.fixedDeltaTime;
            // At the speed of the world. As floats both are not quite what they are called.
            if (!played || since < Dt - 0.001) return;
            since = 0;
            var (reward, over) = StepByHand();
            steps++;
            total += reward;
            if (!over) return;
            Debug.Log(FormattableString.Invariant($"by hand: {steps} steps, return {total:F1}"));
            steps = 0;
            total = 0;
            ResetByHand(new RandomGenerator(++seed));
        }
    }
}
