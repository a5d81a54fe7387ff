// Lesson 11, the agents that Python asks for: who has which name now, and who had it last.
using System;
using System.Collections.Generic;
using System.Linq;

namespace NetMQExample
{
    /// <summary>Those of the last reset. Each has a row in each request, and in each answer.</summary>
    internal sealed class AskedAgents
    {
        private readonly Dictionary<string, IAgent> last = new Dictionary<string, IAgent>();
        private readonly IReadOnlyList<IAgent> agents;

        /// <summary>Of the agents that are in the list when they are looked for.</summary>
        public AskedAgents(IReadOnlyList<IAgent> agents) => this.agents = agents;

        /// <summary>How many there are.</summary>
        public int Count => Names.Count;

        /// <summary>Of each row.</summary>
        public List<string> Names { get; private set; } = new List<string>();

        /// <summary>Of each row, the agent that was there when it looked, or null.</summary>
        public List<IAgent> Present { get; } = new List<IAgent>();

        /// <summary>Whether all are there now that a request is for.</summary>
        public bool AreThere(StepRequest request)
        {
            for (var row = 0; row < Names.Count; row++)
                if (request.OrderOf(row) != Order.Nothing && There(Names[row]) == null) return false;
            return true;
        }

        /// <summary>From now on it is these. A missing one may come by an OnReset.</summary>
        /// <exception cref="MessageException">Two agents have one name.</exception>
        public void Ask(List<object> names)
        {
            Names = names.ConvertAll(name => name as string
                ?? throw new MessageException("wrong-type", "the name of an agent is a text"));
            var twice = Names.Find(name => agents.Count(agent => agent.State.Name == name) > 1);
            if (twice != null) Find(twice);
        }

        /// <summary>Looks for them. Another agent of a name, such as that of a scene that was loaded, goes on with the
        /// episode of the one before.</summary>
        public void Recognize(StepRequest request)
        {
            Present.Clear();
            for (var row = 0; row < Names.Count; row++)
            {
                var agent = There(Names[row]);
                Present.Add(agent);
                if (agent == null) continue;
                var before = Last(row);
                if (before != null && before != agent)
                    agent.State.GoOnFrom(before.State, request.OrderOf(row) == Order.Reset);
                last[Names[row]] = agent;
            }
        }

        /// <summary>The agent that was there last, also if it has left.</summary>
        public IAgent Last(int row) => last.GetValueOrDefault(Names[row]);

        /// <summary>Those that can be reset now. One that has left may be switched on by its own OnReset.</summary>
        /// <param name="rows">Those to look for.</param>
        /// <param name="exists">Whether an agent that has left could come back.</param>
        public List<(int Row, IAgent Agent)> Known(List<int> rows, Func<IAgent, bool> exists)
        {
            var known = rows.Select(row => (Row: row, Agent: There(Names[row]) ?? Last(row)))
                .Where(one => one.Agent != null && exists(one.Agent)).ToList();
            foreach (var (row, agent) in known) last[Names[row]] = agent;
            return known;
        }

        /// <summary>The agent of a name.</summary>
        /// <exception cref="MessageException">There is none, or there are two.</exception>
        public IAgent Find(string name)
        {
            var found = agents.Where(agent => agent.State.Name == name).ToList();
            if (found.Count == 1) return found[0];
            var known = string.Join(", ", agents.Select(agent => agent.State.Name).DefaultIfEmpty("none"));
            throw new MessageException(found.Count == 0 ? "unknown-agent" : "two-agents", found.Count == 0
                ? $"no agent is named '{name}'; there are: {known}"
                : $"{found.Count} agents are named '{name}': each needs a name of its own");
        }

        private IAgent There(string name)
        {
            foreach (var agent in agents) if (agent.State.Name == name) return agent;
            return null;
        }
    }
}
