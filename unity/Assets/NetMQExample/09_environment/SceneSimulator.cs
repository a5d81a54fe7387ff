// Lesson 09, the simulator of agents.
using System;
using System.Collections.Generic;

namespace NetMQExample
{
    /// <summary>Answers hello, reset, step, info and render for all agents of a scene; EnvironmentClient brings it to
    /// Python.</summary>
    public sealed class SceneSimulator : SimulatorBase
    {
        /// <summary>Of the agents that are in the list when Python asks: they may come and go.</summary>
        /// <param name="name">The env_name in Python.</param>
        /// <param name="dt">How many seconds one tick takes.</param>
        /// <param name="agents">All agents of the world.</param>
        /// <param name="world">What belongs to no agent; null if there is nothing.</param>
        /// <param name="sensors">The sensors of the scene, which may come and go as well; null for none.</param>
        public SceneSimulator(string name, double dt, IReadOnlyList<IAgent> agents, IWorld world = null,
            IReadOnlyList<Source> sensors = null) => Name = name;

        /// <inheritdoc/>
        public override string Name { get; }

        /// <summary>By name, how many agents there may be, where these are more than at the hello.</summary>
        public Dictionary<string, int> AtMost { get; } = new Dictionary<string, int>();

        /// <summary>Called with a line that a person should read.</summary>
        public Action<string> Warn { get; set; } = line => { };

        /// <summary>Hears what Python sends to the environment itself.</summary>
        public event Action<object> OnInfo;

        /// <summary>Tells Python something of the environment itself, with the next answer.</summary>
        /// <exception cref="MessageException">It has no place in a message.</exception>
        public void SendInfo(object info) => OnInfo?.Invoke(info);

        /// <summary>The episode is over for every agent.</summary>
        public void Terminate() { }

        /// <summary>The episode is over for every agent, for another reason, such as the time.</summary>
        public void Truncate() { }

        /// <inheritdoc/>
        public override Message Describe() => throw new NotImplementedException();

        /// <inheritdoc/>
        public override Message Say(Message request) => throw new NotImplementedException();

        /// <inheritdoc/>
        public override bool Do(StepRequest request, StepAnswer answer, bool again) => throw new NotImplementedException();
    }
}
