// Lesson 10, agents: several of them in one world, and one message has an array for each that lives.
//
// A hello says in "agents" who there is and of what kind their spaces are. A step has an action for each agent that
// lives, in the order of the hello. The answer's "infos" name these agents; its arrays are rewards float64 [n],
// terminated and truncated uint8 [n], and what each of them sees. Whoever is over then has no part in the next step.
// An info brings infos for agents, and takes back in "told" what the game had to say, as each answer does.
// The Python side is python/netmq_example/envs/parallel_env.py.
// Trouble: stop the Python program in a game, and start it again.
using System;
using System.Collections.Generic;
using System.Linq;

namespace NetMQExample
{
    /// <summary>Answers reset, step, info and render for a game.</summary>
    public sealed class AgentSimulator : SimulatorBase
    {
        private readonly RealTime game;
        private List<(string Name, GymSpace Observation, GymSpace Action)> living =
            new List<(string, GymSpace, GymSpace)>();

        /// <summary>For a game, which from then on nobody else steps.</summary>
        public AgentSimulator(IAgentSimulation game) => this.game = new RealTime(game);

        /// <inheritdoc/>
        public override string Name => game.Name;

        /// <summary>Brings a game in real time up to the clock; on any other it does nothing.</summary>
        public void CatchUp() => game.CatchUp();

        /// <inheritdoc/>
        protected override Message Describe()
        {
            var hello = new Message("hello") { Values = { ["name"] = game.Name, ["dt"] = game.Dt } };
            hello.Values["agents"] = Infos.Pack(game.Agents.Select(agent => One(agent.Name,
                new Dictionary<string, object>
                { ["observation"] = agent.Observation.Kind, ["action"] = agent.Action.Kind })));
            hello.Arrays.AddRange(game.Agents.SelectMany(a => a.Observation.Arrays.Concat(a.Action.Arrays)));
            return hello;
        }

        /// <inheritdoc/>
        protected override Message Do(Message request)
        {
            switch (request.Kind)
            {
                case "reset":
                    if (!(request.Values.GetValueOrDefault("seed") is long seed))
                        throw new MessageException("missing-field", "reset needs a whole number 'seed'");
                    game.ResetWorld(new Chance(seed), request.Values);
                    living = game.Agents.ToList();
                    Episodes++;
                    return State(request, (agent, info) => (0, false, false));
                case "step":
                    game.Apply(Actions(request));
                    Steps++;
                    return State(request, game.Judge);
                case "info":
                    var infos = Infos.Unpack(request.Values.GetValueOrDefault("infos")).ToList();
                    foreach (var (agent, info) in infos) Hear(agent, info);
                    return new Message("told", request.Id) { Values = { ["told"] = game.Infos.Take() } };
                case "render":
                    return new Message("picture", request.Id) { Arrays = { game.Render() } };
                default:
                    throw new MessageException("unknown-kind",
                        $"kind {MessageJson.Shown(request.Kind)} is none of reset, step, info, render, close");
            }
        }

        private void Hear(string agent, IReadOnlyDictionary<string, object> info)
        {
            if (agent != "" && game.Agents.All(one => one.Name != agent))
                throw new MessageException("unknown-agent", $"there is no agent {MessageJson.Shown(agent)}");
            game.OnInfo(agent, info);
        }

        private Dictionary<string, double[]> Actions(Message request)
        {
            if (living.Count == 0 || request.Arrays.Count != living.Count)
                throw new MessageException("wrong-agents",
                    $"{request.Arrays.Count} actions, but {living.Count} agents live");
            // All of them are looked at before anything moves.
            return living.Zip(request.Arrays, (agent, array) => (agent, array))
                .ToDictionary(one => one.agent.Name, one => one.agent.Action.Read(new[] { one.array }));
        }

        private Message State(Message request,
            Func<string, IDictionary<string, object>, (double Reward, bool Terminated, bool Truncated)> judge)
        {
            var infos = living.Select(agent => new Dictionary<string, object>()).ToArray();
            var judged = living.Select((agent, i) => judge(agent.Name, infos[i])).ToArray();
            var state = new Message("state", request.Id);
            state.Values["infos"] = Infos.Pack(living.Select((agent, i) => One(agent.Name, infos[i])));
            state.Values["told"] = game.Infos.Take();
            state.Arrays.AddRange(Infos.Judged(judged));
            state.Arrays.AddRange(living.Select(agent => game.Observe(agent.Name)));
            living = living.Where((agent, i) => !judged[i].Terminated && !judged[i].Truncated).ToList();
            return state;
        }

        private static (object, IReadOnlyDictionary<string, object>) One(
            string agent, Dictionary<string, object> info) => (agent, info);
    }
}
