// Lesson 09, a simulator around another one. Lessons 13 and 17 override what they add.
namespace NetMQExample
{
    /// <summary>Passes everything on to a simulator, which from then on nobody else asks.</summary>
    public abstract class SimulatorDecorator : SimulatorBase
    {
        private readonly SimulatorBase simulator;

        /// <summary>Wraps a simulator.</summary>
        protected SimulatorDecorator(SimulatorBase simulator) => this.simulator = Require.Given("simulator", simulator);

        /// <inheritdoc/>
        public override string Name => simulator.Name;

        /// <inheritdoc/>
        public override Message Describe() => simulator.Describe();

        /// <inheritdoc/>
        public override Message Say(Message request) => simulator.Say(request);

        /// <inheritdoc/>
        public override bool Do(StepRequest request, StepAnswer answer, bool again)
        {
            var done = simulator.Do(request, answer, again);
            Episodes = simulator.Episodes;
            Steps = simulator.Steps;
            return done;
        }
    }
}
