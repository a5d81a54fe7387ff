// ML-Agents' shape, a group: agents that earn together. A script makes it and registers its agents.
using System;
using System.Collections.Generic;
using System.Threading;

namespace NetMQExample.MLAgents
{
    /// <summary>Agents that belong together.</summary>
    public interface IMultiAgentGroup
    {
        int GetId();

        void RegisterAgent(Agent agent);

        void UnregisterAgent(Agent agent);
    }

    /// <summary>Rewards and ends for all of its agents. An agent that is disabled leaves it.</summary>
    public class SimpleMultiAgentGroup : IMultiAgentGroup, IDisposable
    {
        private static int made;

        private readonly List<Agent> agents = new List<Agent>();
        private readonly int id = Interlocked.Increment(ref made);

        public int GetId() => id;

        /// <exception cref="UnityAgentsException">It is in another group.</exception>
        public virtual void RegisterAgent(Agent agent)
        {
            if (agents.Contains(agent)) return;
            if (agent.Life.GroupId != 0 && agent.Life.GroupId != id)
                throw new UnityAgentsException($"{agent.name} is in another group: unregister it there first");
            agent.Life.GroupId = id;
            agent.Life.Left += UnregisterAgent;
            agents.Add(agent);
        }

        public virtual void UnregisterAgent(Agent agent)
        {
            if (!agents.Remove(agent)) return;
            agent.Life.GroupId = 0;
            agent.Life.Left -= UnregisterAgent;
        }

        public IReadOnlyCollection<Agent> GetRegisteredAgents() => agents;

        /// <summary>Adds to the group's reward in each agent's next row.</summary>
        public void AddGroupReward(float reward)
        {
            UnityAgentsException.Finite(reward, nameof(AddGroupReward));
            foreach (var agent in agents) agent.Life.GroupReward += reward;
        }

        /// <summary>Replaces the group's reward in each agent's next row.</summary>
        public void SetGroupReward(float reward)
        {
            UnityAgentsException.Finite(reward, nameof(SetGroupReward));
            foreach (var agent in agents) agent.Life.GroupReward = reward;
        }

        /// <summary>The episode is over for all of them.</summary>
        public void EndGroupEpisode() => Each(agent => agent.EndEpisode());

        /// <summary>The same for another reason than an end of the task, such as the time.</summary>
        public void GroupEpisodeInterrupted() => Each(agent => agent.EpisodeInterrupted());

        public virtual void Dispose() => Each(UnregisterAgent);

        // Of a copy: the next episode may begin with others.
        private void Each(Action<Agent> call) => Array.ForEach(agents.ToArray(), call);
    }
}
