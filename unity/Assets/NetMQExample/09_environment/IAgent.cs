// Lesson 09, an agent: somebody who sees and acts. In Unity derive from Agent, and without an engine from PlainAgent.
//
// A step, when Python says so: OnAction of those that act; OnTick of all, and physics, for Step Period ticks; OnStepped
// of those that have acted; Observe. In Python: scene/agent.py.
using System.Collections.Generic;

namespace NetMQExample
{
    /// <summary>What is asked of an agent, and in which order.</summary>
    public interface IAgent
    {
        /// <summary>Its name, its rewards and whatever else is known of it.</summary>
        AgentState AgentState { get; }

        /// <summary>The space of what it sees; null: its attributes say that.</summary>
        GymSpace Observation { get; }

        /// <summary>The space of what it does; null: Python says that.</summary>
        GymSpace Action { get; }

        void OnReset();

        /// <summary>An action in <see cref="Action"/>: <c>action[0]</c> is its first number. The next one comes in the
        /// same object, so copy the numbers that you keep.</summary>
        void OnAction(SpaceReader action);

        /// <summary>An action of no space in C#: long, double, bool, string, MessageArray, List&lt;object&gt;,
        /// Dictionary&lt;string, object&gt;, or GraphInstance.</summary>
        void OnAction(object action);

        /// <summary>One tick of the world, of so many seconds; none more once its episode is over.</summary>
        void OnTick(double dt);

        /// <summary>A step is done, with all that physics has done in it: the place for rewards and ends.</summary>
        void OnStepped();

        /// <summary>Says what is seen now, such as <c>seen.Add(x, y)</c>.</summary>
        void Observe(SpaceWriter seen);

        /// <summary>Python's send_info, of the same types as an action.</summary>
        void OnInfo(object info);

        /// <summary>A picture, uint8 [height, width, 3], the highest row first; null: it draws none.</summary>
        MessageArray Render();
    }

    /// <summary>The world that agents share, and that belongs to none of them.</summary>
    public interface IWorld
    {
        /// <summary>Episodes of all agents begin, before any OnReset of theirs.</summary>
        /// <param name="random">Where all that is random comes from; of the first agent's seed.</param>
        /// <param name="options">The options that Python gave to reset, by name.</param>
        void OnReset(RandomGenerator random, IReadOnlyDictionary<string, object> options);

        /// <summary>One tick, after those of the agents, and before physics.</summary>
        void OnTick(double dt);

        /// <summary>A step is done, after those of the agents.</summary>
        void OnStepped();

        /// <summary>A picture of all, in place of the agents' own; null: it draws none.</summary>
        MessageArray Render();
    }

    /// <summary>Derive from it, and override what is seen and done. Its members are those of Agent.cs.</summary>
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
        protected virtual int StateSize => 0;
        protected RandomGenerator Rng => AgentState.Rng;
        protected IReadOnlyDictionary<string, object> Options => AgentState.Options;
        protected double[] FirstState => AgentState.FirstState;
        public IDictionary<string, object> Info => AgentState.Info;
        protected double Dt => AgentState.Dt;

        public void AddReward(double more) => AgentState.AddReward(more);
        public void SetReward(double all) => AgentState.SetReward(all);
        public void Terminate() => AgentState.Terminate();
        public void Truncate() => AgentState.Truncate();
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
