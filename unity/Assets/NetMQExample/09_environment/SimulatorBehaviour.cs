// Lesson 09 in Unity: what every scene shares that Python steps, be it one world or many.
//
// Physics is stepped by this component alone, and stands still while Python thinks. No frame waits for that: Update
// takes what has come, and goes on to the next frame when nothing more does. A game that Python launches takes the
// endpoint from its command line, and quits when Python closes it.
using System;
using System.Threading;
using UnityEngine;
using Stopwatch = System.Diagnostics.Stopwatch;

namespace NetMQExample
{
    /// <summary>A component with a simulator, which Python asks to step; or it is played by hand.</summary>
    public abstract class SimulatorBehaviour : NetworkBehaviour
    {
        [SerializeField, Min(0), Tooltip("End after so many episodes; 0: when Python closes it")] private int count;
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait for an environment")] private float patience = 30;
        [SerializeField, Tooltip("Play with Heuristic, without Python; from the next Play on")] private bool byHand;

        private SimulationMode before;
        private volatile bool launched;
        // As it was when this began: whoever ticks it meanwhile has to disable and enable the component.
        private bool played;
        private long seed;
        private int steps;
        private double total, since;

        /// <summary>How many seconds one step takes.</summary>
        public virtual double Dt => 0.02;

        /// <summary>Where the environment listens.</summary>
        protected abstract string Endpoint { get; }

        /// <summary>What answers for this scene.</summary>
        protected abstract SimulatorBase MakeSimulator();

        /// <summary>Begins an episode that is played by hand.</summary>
        protected abstract void ResetByHand(Chance chance);

        /// <summary>One step by hand.</summary>
        /// <returns>What it was worth, and whether the episode is over.</returns>
        protected abstract (double Reward, bool Over) StepByHand();

        /// <inheritdoc/>
        protected override void Begin()
        {
            (before, Physics.simulationMode) = (Physics.simulationMode, SimulationMode.Script);
            played = byHand;
            if (played) ResetByHand(new Chance(seed));
            else base.Begin();
        }

        /// <inheritdoc/>
        protected override void OnDisable()
        {
            if (!played) base.OnDisable();
            Physics.simulationMode = before;
        }

        /// <inheritdoc/>
        protected override void Talk(CancellationToken stop)
        {
            var words = Environment.GetCommandLineArgs();
            var told = Array.IndexOf(words, "--endpoint") + 1;
            var place = told > 0 && told < words.Length ? words[told] : Endpoint;
            launched = told > 0;
            Log($"asking {place}");
            var simulator = MakeSimulator();
            simulator.Mistake = Debug.LogException;
            using var client = new EnvironmentClient(place, Seconds(patience), Log);
            client.Run(simulator, count, FromUpdate, stop);
            Log($"done: {simulator.Episodes} episodes, {simulator.Steps} steps");
        }

        /// <inheritdoc/>
        protected override void Update()
        {
            // While Python steps, its next request comes within a millisecond. When none does, the frame goes on.
            var clock = Stopwatch.StartNew();
            for (var wait = 0; !played && clock.ElapsedMilliseconds < 10 && DoNext(wait); wait = 1) { }
            // In the editor this does nothing. Not before the last line was logged.
            if (launched && Done) Application.Quit();
        }

        /// <summary>Plays by hand.</summary>
        protected virtual void FixedUpdate()
        {
            since += Time.fixedDeltaTime;
            // At the speed of the world. As floats both are not quite what they are called.
            if (!played || since < Dt - 0.001) return;
            since = 0;
            var (reward, over) = StepByHand();
            (steps, total) = (steps + 1, total + reward);
            if (!over) return;
            Debug.Log(FormattableString.Invariant($"by hand: {steps} steps, return {total:F1}"));
            (steps, total) = (0, 0);
            ResetByHand(new Chance(++seed));
        }
    }
}
