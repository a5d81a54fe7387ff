// Lesson 11, the simulator of agents: answers for all of them in one message, and each request once.
//
// Its resets and steps are records (lesson 09, Records.cs), with a row for each agent that is asked for. The options of
// a reset are {"agents": names, "options": {...}}, and the rows keep the order of these names. An action is any value
// (MessageTree.cs); what is seen are locators, each with a value, and an info is {"env": [...], "agent": [...]}. The
// message info has [name or "", info]. Only the agents that are asked for act, and only what they see is sent.
// The Python side is netmq_example/envs/unity_env.py.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Linq;

namespace NetMQExample
{
    /// <summary>Answers reset, step and info; lesson 09's EnvironmentClient brings it to Python.</summary>
    public sealed class SceneSimulator : SimulatorBase
    {
        // How long a scene may load and its agents may come: Python waits for 10 s as a rule.
        private static readonly TimeSpan MostLoading = TimeSpan.FromSeconds(8);

        private readonly double dt;
        private readonly IReadOnlyList<IAgent> agents;
        private readonly IReadOnlyList<Source> sensors;
        private readonly Action tick;
        private readonly List<object> infos = new List<object>();
        private readonly List<Source> seen = new List<Source>();
        private readonly Dictionary<string, object> info = new Dictionary<string, object>();
        private readonly Stopwatch since = new Stopwatch();
        private readonly AskedAgents asked;
        private Dictionary<string, object> options = new Dictionary<string, object>();
        // An agent judges in its Update: then each step needs a frame.
        private bool framed, frameLeft;
        // Whether it was said that nobody hears what Python sends to the environment.
        private bool unheard;
        // A scene was being loaded before this request, and since then.
        private bool loadedBefore;
        private StepRequest current;

        /// <summary>Of the agents that are in the list when Python asks: they may come and go.</summary>
        /// <param name="name">The env_name in Python.</param>
        /// <param name="dt">How many seconds one tick takes.</param>
        /// <param name="agents">All agents of the world.</param>
        /// <param name="sensors">The sensors of the scene, which may come and go as well; null for none.</param>
        /// <param name="tick">One tick of whatever moves besides the agents; null if nothing does.</param>
        public SceneSimulator(string name, double dt, IReadOnlyList<IAgent> agents,
            IReadOnlyList<Source> sensors = null, Action tick = null)
        {
            Name = Require.Given("name", name);
            this.dt = dt;
            this.agents = Require.Given("agents", agents);
            asked = new AskedAgents(agents);
            this.sensors = sensors ?? new Source[0];
            this.tick = tick;
        }

        /// <inheritdoc/>
        public override string Name { get; }

        /// <summary>Whether a scene is being loaded, such as by an agent's OnReset: its agents come with it.</summary>
        public Func<bool> Loads { get; set; } = () => false;

        /// <summary>Whether an agent that has left could come back: in Unity it is not destroyed.</summary>
        public Func<IAgent, bool> Exists { get; set; } = agent => true;

        /// <summary>Whether it waits for the agents of a scene that was loaded.</summary>
        internal bool Loading { get; private set; }

        /// <summary>Called with a line that a person should read.</summary>
        public Action<string> Warn { get; set; } = line => { };

        /// <summary>Hears what Python sends to the environment itself.</summary>
        public event Action<object> OnInfo;

        /// <summary>Those who hear it in every scene, or null.</summary>
        internal Func<Action<object>> Others { get; set; } = () => null;

        /// <summary>The scene of those who heard is left.</summary>
        internal void ForgetListeners() => OnInfo = null;

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
        public override Message Describe() => HelloOf(Name, dt, new Dictionary<string, object>());

        /// <inheritdoc/>
        public override Message Say(Message request)
        {
            if (request.Kind != "info") throw Unknown(request, "info");
            var (to, said) = InfoOf(request);
            AgentState.Inside = true;
            try
            {
                if (to == "") (OnInfo + Others() ?? Unheard)(said);
                else Find(to).OnInfo(said);
            }
            finally { AgentState.Inside = false; }
            return new Message("told", request.Id);
        }

        /// <inheritdoc/>
        public override void Do(StepRequest request, StepAnswer answer)
        {
            if (request.Has(Order.Reset)) Ask(request.ReadOptions());
            if (request.Count != asked.Count)
                throw new MessageException("wrong-agents",
                    $"{request.Count} rows, but {asked.Count} agents were asked for");
            current = request;
            since.Restart();
            Loading = false;
            // One that is only kept ready is none to wait for, unless an OnReset wants it.
            loadedBefore = Loads() && !request.Has(Order.Reset);
            Recognize();
            AgentState.Inside = true;
            try
            {
                if (request.Has(Order.Step)) Step(request);
                if (request.Has(Order.Reset)) Reset(request);
            }
            finally { AgentState.Inside = false; }
            frameLeft = framed && request.Has(Order.Step);
        }

        /// <inheritdoc/>
        public override bool NeedsFrame()
        {
            // The holder of a name may be destroyed at the end of this frame, and another one has come for it.
            var first = frameLeft || AgentRoster.Unsettled;
            frameLeft = false;
            if (since.Elapsed > MostLoading) return false;
            var loads = Loads() && !loadedBefore;
            Loading |= loads;
            return first || loads || (Loading && !asked.AreThere(current));
        }

        /// <inheritdoc/>
        public override void See(StepRequest request, StepAnswer answer)
        {
            Recognize();
            Loading = false;
            for (var i = 0; i < asked.Count; i++)
            {
                if (request.OrderOf(i) == Order.Reset) AgentRoster.Check(asked.Names[i], Exists);
                if (request.OrderOf(i) == Order.Nothing) answer.SkipRow();
                else if (asked.Present[i] != null) See(asked.Present[i].State, answer);
                // No OnReset, and no scene that was loaded, has brought it.
                else if (request.OrderOf(i) == Order.Reset) Find(asked.Names[i]);
                else EndAbsent(i, answer);
            }
            infos.Clear();
        }

        private void Unheard(object said)
        {
            if (!unheard)
                Warn("trouble: Python has sent an info to the environment, and nobody hears it: "
                    + "name an agent in send_info, or add a handler to GymEnv.OnInfo");
            unheard = true;
        }

        private void Ask(Dictionary<string, object> said)
        {
            if (!(said.GetValueOrDefault("agents") is List<object> names
                && said.GetValueOrDefault("options") is Dictionary<string, object> given))
                throw new MessageException("missing-field", "a reset has a list of agents, and options");
            options = given;
            asked.Ask(names);
        }

        private void Recognize()
        {
            asked.Recognize(current);
            var late = framed ? -1 : asked.Present.FindIndex(agent => agent?.State.Late != null);
            if (late < 0 || current.OrderOf(late) != Order.Step) return;
            framed = true;
            var what = asked.Present[late].State.Late;
            Warn($"trouble: agent '{asked.Names[late]}' called {what} between two steps, such as in its Update: from "
                + "now on each step waits for a frame; in OnAction or OnTick it belongs to its step, at full speed");
        }

        private void Reset(StepRequest request)
        {
            // Agents of one seed draw from the same numbers, one after the other.
            var generators = new Dictionary<long, RandomGenerator>();
            var waiting = Enumerable.Range(0, asked.Count).Where(i => request.OrderOf(i) == Order.Reset).ToList();
            foreach (var i in waiting)
                if (!generators.ContainsKey(request.Seed(i)))
                    generators[request.Seed(i)] = new RandomGenerator(request.Seed(i));
            if (waiting.Count == asked.Count)
            {
                infos.Clear();
                // Also those whom Python does not ask: they move.
                foreach (var agent in agents.Where(agent => !asked.Names.Contains(agent.State.Name)))
                    agent.State.Begin(generators[request.Seed(0)], options);
            }
            // An OnReset may bring back others, which then have their turn.
            for (var each = asked.Known(waiting, Exists); each.Count > 0; each = asked.Known(waiting, Exists))
            {
                foreach (var (i, agent) in each)
                {
                    agent.State.Begin(generators[request.Seed(i)], options);
                    waiting.Remove(i);
                }
                foreach (var (_, agent) in each) agent.OnReset();
                Episodes += each.Count;
            }
        }

        private void Step(StepRequest request)
        {
            var acting = new List<(IAgent Agent, object Action)>();
            for (var i = 0; i < asked.Count; i++)
            {
                // An agent that has left since does not act, and the answer lacks it.
                var agent = request.OrderOf(i) == Order.Step ? asked.Present[i] : null;
                if (agent != null) acting.Add((agent, MessageTree.Read(request.Row(i))));
            }
            // Each may switch others off.
            foreach (var (agent, action) in acting) if (agents.Contains(agent)) agent.OnAction(action);
            var left = acting.Select(one => one.Agent.State.Period).DefaultIfEmpty().Max();
            // Nothing after the end belongs to a step.
            for (; left > 0 && !acting.All(one => one.Agent.State.Over); left--)
            {
                foreach (var agent in agents.ToArray())
                    if (!agent.State.Over && agents.Contains(agent)) agent.OnTick(dt);
                tick?.Invoke();
            }
            Steps++;
        }

        internal IAgent Find(string name) => asked.Find(name);

        private void EndAbsent(int row, StepAnswer answer)
        {
            info.Clear();
            var verdict = asked.Last(row)?.State.Take(info) ?? (0, false, false);
            if (infos.Count > 0) info["env"] = new List<object>(infos);
            answer.EndAbsent(verdict, info);
        }

        // In the order of their locators: the whole of a thing before its parts, and the same on every side.
        private void See(AgentState agent, StepAnswer answer)
        {
            seen.Clear();
            foreach (var other in agents) Add(other.State.Sources, agent.Name);
            Add(sensors, agent.Name);
            MessageTree.WritePairs(answer.Rows, seen.OrderBy(source => source.Text, StringComparer.Ordinal)
                .Select(source => (source.Text, source.Read())));
            info.Clear();
            var verdict = agent.Take(info);
            if (infos.Count > 0) info["env"] = new List<object>(infos);
            answer.EndRow(agent.Name, verdict, info);
        }

        private void Add(IReadOnlyList<Source> sources, string agent)
        {
            foreach (var source in sources) if (source.Names(agent)) seen.Add(source);
        }
    }
}
