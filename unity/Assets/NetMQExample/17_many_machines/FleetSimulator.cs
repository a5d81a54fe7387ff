// Lesson 17, the simulator: lesson 09's, which also says of which build it is. In Python: fleet/simulator.py.
//
// An episode that was begun elsewhere is done again here, and must go the same way. So the hub takes simulators of one
// build only; write another one wherever yours computes differently.
using System;
using System.Threading;

namespace NetMQExample
{
    /// <summary>Answers reset, step and render for one simulation of a fleet.</summary>
    public sealed class FleetSimulator : Simulator
    {
        private readonly string build;

        /// <summary>For a simulation, which from then on nobody else steps.</summary>
        /// <param name="simulation">The simulation.</param>
        /// <param name="build">What the hub must expect.</param>
        public FleetSimulator(ISimulation simulation, string build) : base(simulation) =>
            this.build = Require.Given("build", build);

        /// <summary>Trouble on command: called instead of one more step than <see cref="CrashAfter"/>, if that is not
        /// 0.</summary>
        public Action<string> Crash { get; set; }

        /// <summary>After how many steps it crashes.</summary>
        public int CrashAfter { get; set; }

        /// <summary>Trouble on command: how long each step takes.</summary>
        public TimeSpan Delay { get; set; }

        /// <inheritdoc/>
        protected override Message Describe()
        {
            var hello = base.Describe();
            hello.Values["build"] = build;
            return hello;
        }

        /// <inheritdoc/>
        protected override Message Do(Message request)
        {
            if (request.Kind == "step")
            {
                if (CrashAfter > 0 && Steps >= CrashAfter) Crash?.Invoke($"crash after {Steps} steps, as told");
                Thread.Sleep(Delay);
            }
            return base.Do(request);
        }
    }
}
