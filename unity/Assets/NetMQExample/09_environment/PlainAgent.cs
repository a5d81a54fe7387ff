// Lesson 09, an agent without an engine, for a terminal. In Unity it is Agent.cs, with the same members.
using System.Collections.Generic;

namespace NetMQExample
{
    /// <summary>Derive from it: declare what is seen and done, and what a step does.</summary>
    public abstract class PlainAgent : IAgent
    {
        private readonly string name;
        private readonly int period;
        private AgentState state;

        /// <summary>An agent of a name, a step of which takes so many ticks. Several of one name are NAME_0, NAME_1 and
        /// so on.</summary>
        protected PlainAgent(string name = "agent", int period = 1)
        {
            this.name = Require.Given("name", name);
            this.period = period;
        }

        /// <inheritdoc/>
        public AgentState AgentState => state ??= new AgentState(name, this, period) { StateSize = StateSize };

        /// <summary>Its name in Python.</summary>
        public string Name => AgentState.Name;

        /// <inheritdoc/>
        public virtual GymSpace Observation => null;

        /// <inheritdoc/>
        public virtual GymSpace Action => null;

        /// <summary>How many numbers the option "state" has, in which an episode can begin.</summary>
        protected virtual int StateSize => 0;

        /// <summary>The random numbers of this episode, which Python's seed decides.</summary>
        protected RandomGenerator Rng => AgentState.Rng;

        /// <summary>The options that Python gave to reset.</summary>
        protected IReadOnlyDictionary<string, object> Options => AgentState.Options;

        /// <summary>The option "state": <see cref="StateSize"/> numbers, or none.</summary>
        protected double[] FirstState => AgentState.FirstState;

        /// <summary>Named infos of this step, for Python.</summary>
        public IDictionary<string, object> Info => AgentState.Info;

        /// <summary>Seconds of one of its steps.</summary>
        protected double Dt => AgentState.Dt;

        /// <summary>Adds to the reward that goes with the next answer.</summary>
        public void AddReward(double more) => AgentState.AddReward(more);

        /// <summary>Replaces the reward that goes with the next answer.</summary>
        public void SetReward(double all) => AgentState.SetReward(all);

        /// <summary>The episode is over for it: it has reached an end of the world.</summary>
        public void Terminate() => AgentState.Terminate();

        /// <summary>The episode is over for it, for another reason, such as the time.</summary>
        public void Truncate() => AgentState.Truncate();

        /// <summary>Tells Python something, with the next answer.</summary>
        public void SendInfo(object info) => AgentState.SendInfo(info);

        /// <inheritdoc/>
        public virtual void OnReset() { }

        /// <inheritdoc/>
        public virtual void OnAction(SpaceReader action) => OnAction(action.Value);

        /// <inheritdoc/>
        public virtual void OnAction(object action) { }

        /// <inheritdoc/>
        public virtual void OnTick(double dt) { }

        /// <inheritdoc/>
        public virtual void OnStepped() { }

        /// <inheritdoc/>
        public virtual void Observe(SpaceWriter seen) { }

        /// <inheritdoc/>
        public virtual void OnInfo(object info) { }

        /// <inheritdoc/>
        public virtual MessageArray Render() => null;
    }
}
