// Lesson 11, the simulator of agents: answers for all of them in one message, and each request once.
//
//     reset, seed      {"agents": names, "options": {...}}      state    {"agents": {name: what is known of it},
//     step             {"actions": {name: action}}                        "infos": [...],
//     info             {"to": name or "", "info": value}        ok        "observations": [[locator, value], ...]}
// Each { } is the text "state" of its message, a tree (MessageTree.cs). Only the agents that are asked for act, and
// only what they see is sent.
// The Python side is netmq_example/envs/unity_env.py.
using System;
using System.Collections.Generic;
using System.Linq;

namespace NetMQExample
{
    /// <summary>Answers reset, step and info; lesson 09's EnvironmentClient brings it to Python.</summary>
    public sealed class SceneSimulator : SimulatorBase
    {
        private readonly double dt;
        private readonly IReadOnlyList<IAgent> agents;
        private readonly IReadOnlyList<Source> sensors;
        private readonly Action tick;
        private readonly List<object> infos = new List<object>();

        /// <summary>Of the agents that are in the list when Python asks: they may come and go.</summary>
        /// <param name="name">The env_name in Python.</param>
        /// <param name="dt">How many seconds one tick takes.</param>
        /// <param name="agents">All agents of the world.</param>
        /// <param name="sensors">What is seen besides; they may come and go as well. Null: nothing.</param>
        /// <param name="tick">One tick of whatever moves besides the agents; null if nothing does.</param>
        public SceneSimulator(string name, double dt, IReadOnlyList<IAgent> agents,
            IReadOnlyList<Source> sensors = null, Action tick = null)
        {
            Name = Require.Given("name", name);
            this.dt = dt;
            this.agents = Require.Given("agents", agents);
            this.sensors = sensors ?? new Source[0];
            this.tick = tick;
        }

        /// <inheritdoc/>
        public override string Name { get; }

        /// <summary>Hears what Python sends to the environment itself.</summary>
        public event Action<object> OnInfo;

        /// <summary>Tells Python something of the environment itself, with the next answer.</summary>
        /// <exception cref="MessageException">It has no place in a message.</exception>
        public void SendInfo(object info) => infos.Add(Observed.Of(info));

        /// <summary>The episode is over for every agent.</summary>
        public void Terminate()
        {
            foreach (var agent in agents) agent.State.Terminate();
        }

        /// <summary>The episode is over for every agent, for another reason, such as the time.</summary>
        public void Truncate()
        {
            foreach (var agent in agents) agent.State.Truncate();
        }

        /// <inheritdoc/>
        protected override Message Describe() =>
            new Message("hello") { Values = { ["name"] = Name, ["dt"] = dt } };

        /// <inheritdoc/>
        protected override Message Do(Message request)
        {
            if (!(request.Values.GetValueOrDefault("state") is string text)
                || !(MessageTree.Read(text, request.Arrays) is Dictionary<string, object> said))
                throw new MessageException("missing-field", "there is no text 'state' that is a dict");
            switch (request.Kind)
            {
                case "reset" when said.GetValueOrDefault("agents") is List<object> names
                    && said.GetValueOrDefault("options") is Dictionary<string, object> options
                    && request.Values.GetValueOrDefault("seed") is long seed:
                    return State(request, Reset(seed, options, names));
                case "step" when said.GetValueOrDefault("actions") is Dictionary<string, object> actions:
                    return State(request, Step(actions));
                case "info" when said.GetValueOrDefault("to") is string to && said.ContainsKey("info"):
                    if (to == "") OnInfo?.Invoke(said["info"]);
                    else Find(to).OnInfo(said["info"]);
                    return new Message("ok", request.Id);
            }
            throw new MessageException("unknown-kind",
                $"kind {MessageJson.Shown(request.Kind)} with these fields is none of reset, step, info, close");
        }

        private List<IAgent> Reset(long seed, Dictionary<string, object> options, List<object> names)
        {
            var asked = names.Select(name => Find(name as string)).Distinct().ToList();
            var chance = new Chance(seed);
            infos.Clear();
            // Also for those whom Python does not ask: they move.
            foreach (var agent in agents) agent.State.Begin(chance, options);
            foreach (var agent in asked) agent.OnReset();
            Episodes++;
            return asked;
        }

        private List<IAgent> Step(Dictionary<string, object> actions)
        {
            // Whoever has left since does not act; the answer is without it.
            var asked = actions.Keys.Where(name => agents.Any(agent => agent.State.Name == name)).Select(Find).ToList();
            foreach (var agent in asked) agent.OnAction(actions[agent.State.Name]);
            var left = asked.Select(agent => agent.State.Period).DefaultIfEmpty().Max();
            // What comes after the end belongs to no step.
            for (; left > 0 && !asked.All(agent => agent.State.Over); left--)
            {
                foreach (var agent in agents.ToArray())
                    if (!agent.State.Over) agent.OnTick(dt);
                tick?.Invoke();
            }
            Steps++;
            return asked.Where(agents.Contains).ToList();
        }

        private IAgent Find(string name)
        {
            var found = agents.Where(agent => agent.State.Name == name).ToList();
            if (found.Count == 1) return found[0];
            var known = string.Join(", ", agents.Select(agent => agent.State.Name));
            throw new MessageException(found.Count == 0 ? "unknown-agent" : "two-agents", found.Count == 0
                ? $"no agent is named '{name}'; there are: {known}"
                : $"{found.Count} agents are named '{name}': each needs a name of its own");
        }

        // In the order of their locators: the whole of a thing before its parts, and the same on every side.
        private Message State(Message request, List<IAgent> asked)
        {
            var state = new Message("state", request.Id);
            var observations = new List<object>();
            foreach (var source in agents.SelectMany(agent => agent.State.Sources).Concat(sensors)
                .Where(source => asked.Any(agent => source.Locator.Mappings.Any(one => one.Names(agent.State.Name))))
                .OrderBy(source => source.Locator.ToString(), StringComparer.Ordinal))
                observations.Add(new List<object> { source.Locator.ToString(), source.Read() });
            var tree = new Dictionary<string, object>
            {
                ["agents"] = asked.ToDictionary(agent => agent.State.Name, agent => (object)agent.State.Take()),
                ["infos"] = new List<object>(infos),
                ["observations"] = observations,
            };
            infos.Clear();
            state.Values["state"] = MessageTree.Write(tree, state.Arrays);
            return state;
        }
    }
}
