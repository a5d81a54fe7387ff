// Lesson 10, real time: the world goes on while Python thinks, for whoever asks for it. In Python: simulation.py.
//
// AgentSimulator puts each game into this shell. It is stepped as ever, until a reset has the option real_time. From
// then on each step first makes up for the ticks that the clock has seen since the last one, with the actions from
// then; rewards are summed. It is Python that keeps the pace: it sends no more than one step for each tick.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Linq;

namespace NetMQExample
{
    /// <summary>Another game around a game.</summary>
    public sealed class RealTime : IAgentSimulation
    {
        // Seconds. After a longer sleep of the computer it makes up for no more than this.
        private const double MostSeconds = 10;

        private readonly IAgentSimulation game;
        private readonly Stopwatch clock = Stopwatch.StartNew();
        private readonly Dictionary<string, Verdict> verdicts = new Dictionary<string, Verdict>();
        private List<string> living = new List<string>();
        private readonly Dictionary<string, SpaceReader> acting = new Dictionary<string, SpaceReader>();
        private IReadOnlyDictionary<string, SpaceReader> actions;
        private readonly Predicate<string> isOver;
        private bool real;
        private double next;

        /// <summary>Around a game, which from then on nobody else steps.</summary>
        public RealTime(IAgentSimulation game)
        {
            this.game = Require.Given("game", game);
            // Made once: a new one for each step would be garbage.
            isOver = agent => verdicts[agent].Terminated || verdicts[agent].Truncated;
        }

        /// <inheritdoc/>
        public string Name => game.Name;

        /// <inheritdoc/>
        public double Dt => game.Dt;

        /// <inheritdoc/>
        public IReadOnlyList<(string Name, GymSpace Observation, GymSpace Action)> Agents => game.Agents;

        /// <inheritdoc/>
        public InfoQueue Infos => game.Infos;

        /// <inheritdoc/>
        public void ResetWorld(RandomGenerator random, IReadOnlyDictionary<string, object> options)
        {
            game.ResetWorld(random, options);
            real = options.TryGetValue("real_time", out var value) && value is true;
            next = clock.Elapsed.TotalSeconds + Dt;
            living = Agents.Select(agent => agent.Name).ToList();
            actions = new Dictionary<string, SpaceReader>();
            verdicts.Clear();
            foreach (var agent in living) verdicts[agent] = new Verdict();
        }

        /// <inheritdoc/>
        public void Apply(IReadOnlyDictionary<string, SpaceReader> actions)
        {
            // The tick that is due now; those before it were made up for with the actions from then, by CatchUp.
            this.actions = actions;
            Tick();
        }

        /// <summary>Brings the world up to the clock. A scene does so in each FixedUpdate, and so moves on.</summary>
        /// <param name="but">All but so many seconds.</param>
        public void CatchUp(double but = 0)
        {
            var until = clock.Elapsed.TotalSeconds - but;
            for (next = Math.Max(next, until - MostSeconds); real && living.Count > 0 && until >= next;) Tick();
        }

        private void Tick()
        {
            next += Dt;
            if (living.Count == 0) return;
            acting.Clear();
            foreach (var agent in living)
                if (actions.TryGetValue(agent, out var action)) acting[agent] = action;
            game.Apply(acting);
            foreach (var agent in living) Add(agent);
            living.RemoveAll(isOver);
        }

        private void Add(string agent)
        {
            var verdict = verdicts[agent];
            verdict.Info.Clear();
            var (reward, terminated, truncated) = game.RewardAndEnd(agent, verdict.Info);
            verdict.Reward += reward;
            verdict.Terminated = terminated;
            verdict.Truncated = truncated;
        }

        /// <inheritdoc/>
        public void Observe(string agent, SpaceWriter seen) => game.Observe(agent, seen);

        /// <inheritdoc/>
        public (double Reward, bool Terminated, bool Truncated) RewardAndEnd(
            string agent, IDictionary<string, object> info)
        {
            var verdict = verdicts[agent];
            foreach (var value in verdict.Info) info[value.Key] = value.Value;
            var reward = verdict.Reward;
            verdict.Reward = 0;
            return (reward, verdict.Terminated, verdict.Truncated);
        }

        /// <inheritdoc/>
        public void OnInfo(string agent, IReadOnlyDictionary<string, object> info) => game.OnInfo(agent, info);

        /// <inheritdoc/>
        public MessageArray Render() => game.Render();

        private sealed class Verdict
        {
            public readonly Dictionary<string, object> Info = new Dictionary<string, object>();
            public double Reward;
            public bool Terminated, Truncated;
        }
    }
}
