// Lesson 10, a simulation of several agents: what a game needs, so that an environment can be made of it. In Python:
// simulation.py.
using System.Collections.Generic;

namespace NetMQExample
{
    /// <summary>Your own game has these. In Unity derive from PythonAgents, which is one.</summary>
    public interface IAgentSimulation
    {
        /// <summary>Its name in Python.</summary>
        string Name { get; }

        /// <summary>How many seconds one step takes.</summary>
        double Dt { get; }

        /// <summary>All agents, with what each of them sees and does.</summary>
        IReadOnlyList<(string Name, GymSpace Observation, GymSpace Action)> Agents { get; }

        /// <summary>Infos for Python at any time: <c>Infos.Send(agent, info)</c>.</summary>
        InfoQueue Infos { get; }

        /// <summary>Begins an episode, in which all agents live.</summary>
        /// <param name="random">Where all that is random comes from.</param>
        /// <param name="options">The options that Python gave to reset, by name.</param>
        void ResetWorld(RandomGenerator random, IReadOnlyDictionary<string, object> options);

        /// <summary>Does what the agents want, for <see cref="Dt"/> seconds.</summary>
        /// <param name="actions">Of each agent that lives.</param>
        void Apply(IReadOnlyDictionary<string, SpaceReader> actions);

        /// <summary>Says what an agent sees now.</summary>
        void Observe(string agent, SpaceWriter seen);

        /// <summary>How good that was for an agent, and whether it is over for it: then it has no part any more.
        /// </summary>
        /// <param name="agent">Its name.</param>
        /// <param name="info">Takes whatever else Python is to know of it, by name.</param>
        (double Reward, bool Terminated, bool Truncated) RewardAndEnd(string agent, IDictionary<string, object> info);

        /// <summary>Python has said something to an agent; to the environment if the name is empty.</summary>
        void OnInfo(string agent, IReadOnlyDictionary<string, object> info);

        /// <summary>A picture, uint8 [height, width, 3], the highest row first.</summary>
        MessageArray Render();
    }
}
