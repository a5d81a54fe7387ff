// Lesson 09 in Unity: what every scene shares that Python steps, be it one world or many.
//
// Physics is stepped by this component alone, and stands still while Python thinks. A Python that thinks for less than
// 10 ms is waited for, but no frame waits longer than that: else Python would make one step a frame. A game that Python
// launches takes the endpoint from its command line, and quits when Python closes it.
using System;
using System.Collections.Generic;
using System.Threading;
using UnityEngine;
using Stopwatch = System.Diagnostics.Stopwatch;

namespace NetMQExample
{
    /// <summary>A component with a simulator, which Python asks to step.</summary>
    public abstract class SteppedBehaviour : NetworkBehaviour
    {
        [SerializeField, Min(0), Tooltip("End after so many episodes; 0: when Python closes it")] private int count;
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait for an environment")] private float timeout = 30;

        // How many milliseconds a frame may wait for Python's requests.
        private const int MostMilliseconds = 10;

        // Physics is everybody's: the first one that steps it takes it, and the last one gives it back.
        private static readonly HashSet<SteppedBehaviour> Users = new HashSet<SteppedBehaviour>();
        private static SimulationMode before;

        private readonly Stopwatch thinking = new Stopwatch();
        private volatile bool launched, quick;

        /// <summary>Where the environment listens.</summary>
        protected abstract string Endpoint { get; }

        /// <summary>Whether Python steps it; else it has no network thread.</summary>
        protected virtual bool Connects => true;

        /// <summary>What answers for this scene. Called on the network thread.</summary>
        protected abstract SimulatorBase MakeSimulator();

        /// <inheritdoc/>
        protected override void Begin()
        {
            if (Users.Count == 0) before = Physics.simulationMode;
            Users.Add(this);
            Physics.simulationMode = SimulationMode.Script;
            if (Connects) base.Begin();
        }

        /// <inheritdoc/>
        protected override void OnDisable()
        {
            if (Connects) base.OnDisable();
            if (Users.Remove(this) && Users.Count == 0) Physics.simulationMode = before;
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
            using var client = new EnvironmentClient(place, Seconds(timeout), Log);
            client.Run(simulator, count, Perform, stop);
            Log($"done: {simulator.Episodes} episodes, {simulator.Steps} steps");
        }

        private Message Perform(Func<Message> answer)
        {
            quick = thinking.ElapsedMilliseconds < MostMilliseconds;
            var message = FromUpdate(answer);
            thinking.Restart();
            return message;
        }

        /// <inheritdoc/>
        protected override void Update()
        {
            // A Python that thinks fast makes many steps in a frame; else, or when time is up, it goes on.
            var clock = Stopwatch.StartNew();
            for (var wait = 0; Connects && clock.ElapsedMilliseconds < MostMilliseconds && DoNext(wait);)
                wait = quick ? Math.Max(1, MostMilliseconds - (int)clock.ElapsedMilliseconds) : 1;
            // In the editor this does nothing. Not before the last line was logged.
            if (launched && Done) Application.Quit();
        }
    }
}
