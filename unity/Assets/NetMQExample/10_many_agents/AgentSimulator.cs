// Lesson 10, agents: several of them in one world, and one message has an action for each that lives.
//
// A hello lists the agents and their spaces in "agents". A record (Records.cs) has a row for each of them, in that
// order, and says of each whether it steps: all that live do. An agent that is over has no part in the next step. The
// answer's options are the game's infos, [[agent, info], …]. The message info brings an info, as [agent, info], and
// takes back the infos since then.
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
        private readonly Player[] players;
        private readonly Dictionary<string, SpaceReader> actions = new Dictionary<string, SpaceReader>();

        /// <summary>For a game, which from then on nobody else steps.</summary>
        public AgentSimulator(IAgentSimulation game)
        {
            this.game = new RealTime(game);
            players = game.Agents.Select(agent => new Player(agent.Name, agent.Observation, agent.Action)).ToArray();
        }

        /// <inheritdoc/>
        public override string Name => game.Name;

        /// <summary>Brings a game in real time up to the clock; on any other it does nothing.</summary>
        public void CatchUp() => game.CatchUp();

        /// <inheritdoc/>
        public override Message Describe() => HelloOf(game.Name, game.Dt, new Dictionary<string, object>
        {
            ["agents"] = game.Agents.Select(agent => (object)new List<object>
            {
                agent.Name,
                new Dictionary<string, object>
                { ["observation"] = agent.Observation.Description, ["action"] = agent.Action.Description },
            }).ToList(),
        });

        /// <inheritdoc/>
        public override void Do(StepRequest request, StepAnswer answer)
        {
            if (request.Count != players.Length)
                throw new MessageException("wrong-agents",
                    $"{request.Count} rows, but there are {players.Length} agents");
            var resets = !request.Has(Order.Step) && !request.Has(Order.Nothing);
            if (resets) Reset(request);
            else Step(request);
            for (var i = 0; i < players.Length; i++) See(players[i], resets, answer);
            answer.Options = game.Infos.Take();
        }

        /// <inheritdoc/>
        public override Message Say(Message request)
        {
            if (request.Kind == "render") return new Message("picture", request.Id) { Arrays = { game.Render() } };
            if (request.Kind != "info") throw Unknown(request, "info, render");
            var (agent, info) = InfoOf(request);
            if (agent != "" && players.All(player => player.Name != agent))
                throw new MessageException("unknown-agent", $"there is no agent {MessageJson.Shown(agent)}");
            game.OnInfo(agent, info as Dictionary<string, object>
                ?? throw new MessageException("bad-info", "it is no dict"));
            var infos = game.Infos.Take() ?? new byte[0];
            return new Message("told", request.Id) { Arrays = { new MessageArray("uint8", infos, infos.Length) } };
        }

        private void Reset(StepRequest request)
        {
            game.ResetWorld(new RandomGenerator(request.Seed(0)), request.ReadOptions());
            foreach (var player in players) player.Lives = true;
            Episodes++;
        }

        private void Step(StepRequest request)
        {
            var living = 0;
            for (var i = 0; i < players.Length; i++)
            {
                if (players[i].Lives) living++;
                if (request.OrderOf(i) != (players[i].Lives ? Order.Step : Order.Nothing))
                {
                    var why = players[i].Lives ? "lives, and has no action" : "has an action, and is over";
                    throw new MessageException("wrong-agents", $"{players[i].Name} {why}");
                }
            }
            if (living == 0) throw new MessageException("wrong-agents", "nobody lives: reset first");
            // With the actions from before, which are read over now. All of them are looked at before anything moves.
            game.CatchUp(game.Dt);
            actions.Clear();
            for (var i = 0; i < players.Length; i++)
            {
                if (!players[i].Lives) continue;
                players[i].Action.Read(request.Row(i));
                actions[players[i].Name] = players[i].Action;
            }
            game.Apply(actions);
            Steps++;
        }

        private void See(Player player, bool resets, StepAnswer answer)
        {
            if (!player.Lives)
            {
                answer.SkipRow();
                return;
            }
            player.Info.Clear();
            var verdict = resets ? (0, false, false) : game.RewardAndEnd(player.Name, player.Info);
            game.Observe(player.Name, player.Seen.Begin(answer.Rows));
            player.Seen.End();
            answer.EndRow(player.Name, verdict, player.Info);
            player.Lives = !verdict.Item2 && !verdict.Item3;
        }

        private sealed class Player
        {
            public readonly string Name;
            public readonly SpaceReader Action;
            public readonly SpaceWriter Seen;
            public readonly Dictionary<string, object> Info = new Dictionary<string, object>();
            public bool Lives;

            public Player(string name, GymSpace observation, GymSpace action)
            {
                Name = name;
                Seen = new SpaceWriter(observation);
                Action = new SpaceReader(action);
            }
        }
    }
}
