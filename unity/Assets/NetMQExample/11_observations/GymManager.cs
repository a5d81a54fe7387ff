// Lesson 11 in Unity: what an agent sees is said where it is declared. This brings all agents of the scene to Python.
//
// Use: start python/11_observations/server.py, open this lesson's scene, press Play. For your own scene: add this
// component to any GameObject, and agents (Agent.cs) and camera sensors wherever they belong. A game that Python
// launches takes the endpoint from its command line, and quits when Python closes it.
// Nothing moves while Python thinks: for each step OnTick is called, and physics is simulated for as long. What a
// script does in FixedUpdate, it does in OnTick from now on.
using System;
using System.Threading;
using UnityEngine;
using Stopwatch = System.Diagnostics.Stopwatch;

namespace NetMQExample
{
    /// <summary>A scene whose time passes when Python steps.</summary>
    public sealed class GymManager : NetworkBehaviour
    {
        [SerializeField, Tooltip("The environment")] private string endpoint = "tcp://127.0.0.1:5561";
        [SerializeField, Tooltip("The env_name in Python")] private string envName = "Coins";
        [SerializeField, Tooltip("Seconds of a tick")] private double dt = 0.1;
        [SerializeField, Min(0), Tooltip("End after so many episodes; 0: when Python closes it")] private int count;
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait for an environment")] private float patience = 30;

        private SimulationMode before;
        private volatile bool launched;

        /// <summary>What the environment itself says and hears: SendInfo, OnInfo. New after each enable.</summary>
        public SceneSimulator Simulator { get; private set; }

        /// <inheritdoc/>
        protected override void Begin()
        {
            (before, Physics.simulationMode) = (Physics.simulationMode, SimulationMode.Script);
            Simulator = new SceneSimulator(envName, dt, Agent.All, CameraSensor.All, Simulate);
            base.Begin();
        }

        /// <inheritdoc/>
        protected override void OnDisable()
        {
            base.OnDisable();
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
            using var client = new EnvironmentClient(place, Seconds(patience), Log);
            client.Run(Simulator, count, FromUpdate, stop);
            Log($"done: {Simulator.Episodes} episodes, {Simulator.Steps} steps");
        }

        private void Simulate() => Physics.Simulate((float)dt);

        /// <inheritdoc/>
        protected override void Update()
        {
            // While Python steps, its next request comes within a millisecond. When none does, the frame goes on.
            var clock = Stopwatch.StartNew();
            for (var wait = 0; clock.ElapsedMilliseconds < 10 && DoNext(wait); wait = 1) { }
            // In the editor this does nothing. Not before the last line was logged.
            if (launched && Done) Application.Quit();
        }
    }
}
