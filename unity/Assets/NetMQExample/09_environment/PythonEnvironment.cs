// Lesson 09 in Unity: derive from this, and Python decides when time passes in your scene.
//
// Use: start a Python program that makes the environment, add your component to any GameObject, press Play. A game that
// Python launches takes the endpoint from its command line, and quits when Python closes it.
// Physics is stepped by this component alone, and stands still while Python thinks. No frame waits for that: Update
// takes what has come, and goes on to the next frame when nothing more does. To play by hand, without Python, tick
// By Hand.
using System;
using System.Collections.Generic;
using System.Threading;
using UnityEngine;
using Stopwatch = System.Diagnostics.Stopwatch;

namespace NetMQExample
{
    /// <summary>A scene as a Gymnasium environment: say what can be seen and done, and reset, apply, observe,
    /// judge.</summary>
    public abstract class PythonEnvironment : NetworkBehaviour, ISimulation
    {
        [SerializeField, Tooltip("The environment")] private string endpoint = "tcp://127.0.0.1:5559";
        [SerializeField, Min(0), Tooltip("End after so many episodes; 0: when Python closes it")] private int count;
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait for an environment")] private float patience = 30;
        [SerializeField, Tooltip("Play with Heuristic, without Python")] private bool byHand;

        private SimulationMode before;
        private volatile bool launched;
        private long seed;
        private int steps;
        private double total;

        /// <inheritdoc/>
        public abstract string Name { get; }

        /// <inheritdoc/>
        public virtual double Dt => 0.02;

        /// <inheritdoc/>
        public abstract int StateSize { get; }

        /// <inheritdoc/>
        public abstract GymSpace Observation { get; }

        /// <inheritdoc/>
        public abstract GymSpace Action { get; }

        /// <inheritdoc/>
        public abstract void ResetWorld(Chance chance, IReadOnlyDictionary<string, object> options, double[] state);

        /// <summary>Does an action. Physics is simulated after it.</summary>
        protected abstract void Act(double[] action);

        /// <inheritdoc/>
        public abstract MessageArray Observe();

        /// <inheritdoc/>
        public abstract (double Reward, bool Terminated, bool Truncated) Judge(IDictionary<string, object> info);

        /// <inheritdoc/>
        public virtual MessageArray Render() => throw new MessageException("no-picture", $"{Name} draws none");

        /// <summary>What a person does, from Input, when it is played by hand.</summary>
        protected abstract double[] Heuristic();

        /// <inheritdoc/>
        public void Apply(double[] action)
        {
            Act(action);
            Physics.Simulate((float)Dt);
        }

        /// <inheritdoc/>
        protected override void Begin()
        {
            (before, Physics.simulationMode) = (Physics.simulationMode, SimulationMode.Script);
            if (byHand) ResetWorld(new Chance(seed), new Dictionary<string, object>(), new double[0]);
            else base.Begin();
        }

        /// <inheritdoc/>
        protected override void OnDisable()
        {
            if (!byHand) base.OnDisable();
            Physics.simulationMode = before;
        }

        /// <inheritdoc/>
        protected override void Talk(CancellationToken stop)
        {
            var words = Environment.GetCommandLineArgs();
            var told = Array.IndexOf(words, "--endpoint") + 1;
            var place = told > 0 && told < words.Length ? words[told] : endpoint;
            launched = told > 0;
            Log($"asking {place}");
            var simulator = new Simulator(this);
            using var client = new EnvironmentClient(place, Seconds(patience), Log);
            client.Run(simulator, count, FromUpdate, stop);
            Log($"done: {simulator.Episodes} episodes, {simulator.Steps} steps");
        }

        /// <inheritdoc/>
        protected override void Update()
        {
            // While Python steps, its next request comes within a millisecond. When none does, the frame goes on.
            var clock = Stopwatch.StartNew();
            for (var wait = 0; !byHand && clock.ElapsedMilliseconds < 10 && DoNext(wait); wait = 1) { }
            // In the editor this does nothing. Not before the last line was logged.
            if (launched && Done) Application.Quit();
        }

        private void FixedUpdate()
        {
            if (!byHand) return;
            Apply(Heuristic());
            var (reward, terminated, truncated) = Judge(new Dictionary<string, object>());
            (steps, total) = (steps + 1, total + reward);
            if (!terminated && !truncated) return;
            Debug.Log(FormattableString.Invariant($"by hand: {steps} steps, return {total:F1}"));
            (steps, total) = (0, 0);
            ResetWorld(new Chance(++seed), new Dictionary<string, object>(), new double[0]);
        }
    }
}
