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

        public AgentState AgentState => state ??= new AgentState(name, this, period) { StateSize = StateSize };
        public string Name => AgentState.Name;
        public virtual GymSpace Observation => null;
        public virtual GymSpace Action => null;

        /// <summary>How many numbers the option "state" has, in which an episode can begin.</summary>
        protected virtual int StateSize => 0;

        /// <summary>The random numbers of this episode, which Python's seed decides.</summary>
        protected RandomGenerator Rng => AgentState.Rng;

        protected IReadOnlyDictionary<string, object> Options => AgentState.Options;

        /// <summary>The option "state": <see cref="StateSize"/> numbers, or none.</summary>
        protected double[] FirstState => AgentState.FirstState;

        /// <summary>Named infos of this step, for Python.</summary>
        public IDictionary<string, object> Info => AgentState.Info;

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

        public virtual void OnReset() { }
        public virtual void OnAction(SpaceReader action) => OnAction(action.Value);
        public virtual void OnAction(object action) { }
        public virtual void OnTick(double dt) { }
        public virtual void OnStepped() { }
        public virtual void Observe(SpaceWriter seen) { }
        public virtual void OnInfo(object info) { }
        public virtual MessageArray Render() => null;
    }
}
