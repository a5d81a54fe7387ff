// Lesson 17, a simulator of the fleet: any of lessons 09 to 13, which also says of which build it is. In Python:
// fleet/simulator.py.
//
// An episode that was begun elsewhere is done again here, and must go the same way. So the hub takes simulators of one
// build only; write another one wherever yours computes differently.
using System;
using System.Threading;

namespace NetMQExample
{
    /// <summary>Around a simulator, which a hub then knows.</summary>
    public sealed class FleetSimulator : SimulatorDecorator
    {
        private readonly string build;

        public FleetSimulator(SimulatorBase simulator, string build) : base(simulator) =>
            this.build = Require.Given("build", build);

        /// <summary>Trouble on command: called instead of one more step than <see cref="CrashAfter"/>, if that is not
        /// 0.</summary>
        public Action<string> Crash { get; set; }

        public int CrashAfter { get; set; }

        /// <summary>Trouble on command: how long each step takes.</summary>
        public TimeSpan Delay { get; set; }

        public override Message Describe()
        {
            var hello = base.Describe();
            hello.Values["build"] = build;
            return hello;
        }

        public override bool Do(StepRequest request, StepAnswer answer, bool again)
        {
            if (request.Steps && !again)
            {
                if (CrashAfter > 0 && Steps >= CrashAfter) Crash?.Invoke($"crash after {Steps} steps, as told");
                Thread.Sleep(Delay);
            }
            return base.Do(request, answer, again);
        }
    }
}
