// Lesson 09, who takes part: a row for each name, and one agent in each row.
//
// Names are decided at the hello. One agent alone of a name keeps it, unless At Most says more than one; several are
// name_0, name_1 and so on, in the order in which they stand. One that comes later takes the next free number; where
// there is none it waits for a frame, since Unity destroys what has that number at the end of the frame only.
using System;
using System.Collections.Generic;
using System.Linq;

namespace NetMQExample
{
    /// <summary>For one thread, in Unity the main thread.</summary>
    internal sealed class AgentRoster
    {
        private readonly IReadOnlyList<IAgent> agents;
        private readonly IReadOnlyList<Source> sensors;
        private readonly double dt;
        // As they were when it looked last.
        private readonly List<IAgent> known = new List<IAgent>();
        private readonly List<Source> knownSensors = new List<Source>();
        private readonly HashSet<IAgent> refused = new HashSet<IAgent>();
        private List<IAgent> waiting = new List<IAgent>();
        private int renames;
        // Somebody waits for the next exchange: Python does not know yet that the one before has left.
        private bool later;

        public AgentRoster(double dt, IReadOnlyList<IAgent> agents, IReadOnlyList<Source> sensors)
        {
            this.dt = dt;
            this.agents = agents;
            this.sensors = sensors;
            Everyone = () => agents;
            foreach (var agent in agents) Take(agent);
        }

        public List<AgentKind> Kinds { get; } = new List<AgentKind>();

        public List<AgentRow> Rows { get; } = new List<AgentRow>();

        public Dictionary<string, int> AtMost { get; } = new Dictionary<string, int>();

        /// <summary>All agents in the order in which they stand, also those that are switched off.</summary>
        public Func<IReadOnlyList<IAgent>> Everyone { get; set; }

        /// <summary>Whether an agent that has left could come back: in Unity it is not destroyed.</summary>
        public Func<IAgent, bool> Exists { get; set; } = agent => true;

        /// <summary>Called with each agent for which there is no place, and why.</summary>
        public Action<IAgent, string> Refuse { get; set; } = (agent, why) => { };

        /// <summary>Whether somebody waits for a name.</summary>
        public bool Unsettled => waiting.Count > 0;

        /// <summary>The seed of the first agent, as of the last time when all have begun.</summary>
        public long Seed { get; set; }

        public bool Started { get; set; }

        /// <summary>Whether a scene has been loaded in this exchange, or just before it.</summary>
        public bool Loaded { get; set; }

        public void Name()
        {
            Kinds.Clear();
            Rows.Clear();
            waiting.Clear();
            Started = false;
            var all = Everyone();
            var twice = all.GroupBy(agent => agent).FirstOrDefault(group => group.Count() > 1)?.Key;
            if (twice != null)
                throw new MessageException("two-agents",
                    $"{twice.AgentState.Given} is in the scene twice: each row is an agent of its own");
            foreach (var group in all.GroupBy(agent => AgentKind.Split(agent.AgentState.Given).Name))
                Add(group.Key, group.ToList());
            Look(false);
            foreach (var row in Rows) row.Born = false;
        }

        /// <summary>Looks who is there now. Agents of a scene that was loaded take the rows in their order.</summary>
        public void Settle(bool loading)
        {
            if (later || waiting.Count > 0 || renames != AgentState.Renames || !Same(agents, known)
                || !Same(sensors, knownSensors)) Look(loading || Loaded);
        }

        /// <summary>Whether it takes part at this very moment: each agent may switch others off.</summary>
        public bool IsThere(AgentRow row) =>
            row.Present && (row.At < agents.Count && agents[row.At] == row.Agent || agents.Contains(row.Agent));

        public IAgent Find(string name)
        {
            foreach (var agent in agents) if (agent.AgentState.Name == name) return agent;
            var there = string.Join(", ", agents.Select(agent => agent.AgentState.Name).DefaultIfEmpty("none"));
            throw new MessageException("unknown-agent", $"no agent is named '{name}'; there are: {there}");
        }

        private void Add(string name, List<IAgent> own)
        {
            var kind = new AgentKind(name, Kinds.Count, own[0]);
            var most = AtMost.TryGetValue(name, out var given) && given > 0 ? given : own.Count;
            if (own.Count > most) throw new MessageException("no-space", Full(name, most));
            var numbers = own.Select(agent => AgentKind.Split(agent.AgentState.Given).Number).ToArray();
            var twice = own.FirstOrDefault(agent =>
                numbers.Count(number => number >= 0 && number == AgentKind.Split(agent.AgentState.Given).Number) > 1);
            if (twice != null)
                throw new MessageException("two-agents",
                    $"two agents are named '{twice.AgentState.Given}': each needs a name of its own");
            var taken = new HashSet<int>(numbers);
            int Free() => Enumerable.Range(0, int.MaxValue).First(taken.Add);
            if (most > 1)
                for (var i = 0; i < numbers.Length; i++) if (numbers[i] < 0) numbers[i] = Free();
            var places = numbers.Select((number, i) => (Number: number, Agent: own[i])).ToList();
            while (places.Count < most) places.Add((Free(), null));
            foreach (var (number, agent) in places.OrderBy(one => one.Number))
            {
                var row = new AgentRow(kind, kind.Rows.Count, Rows.Count,
                    number < 0 ? name : FormattableString.Invariant($"{name}_{number}"));
                kind.Rows.Add(row);
                Rows.Add(row);
                if (agent == null) continue;
                (row.Agent, row.State) = (agent, Take(agent));
                row.State.Row = row;
                row.State.Call(row.Name);
                kind.Check(agent);
            }
            kind.Located = kind.Observation == null
                || own[0].AgentState.Sources.Any(source => source.Names(own[0].AgentState.Name));
            Kinds.Add(kind);
        }

        private static bool Same<T>(IReadOnlyList<T> now, List<T> before) where T : class
        {
            if (now.Count != before.Count) return false;
            for (var i = 0; i < before.Count; i++) if (!ReferenceEquals(now[i], before[i])) return false;
            return true;
        }

        private void Look(bool loading)
        {
            known.Clear();
            known.AddRange(agents);
            knownSensors.Clear();
            knownSensors.AddRange(sensors);
            var waited = waiting;
            waiting = new List<IAgent>();
            renames = AgentState.Renames;
            later = false;
            refused.IntersectWith(known);
            var was = Rows.Select(row => row.Present).ToArray();
            foreach (var row in Rows) row.At = -1;
            var coming = new List<IAgent>();
            for (var i = 0; i < known.Count; i++)
            {
                var row = known[i].AgentState.Row;
                if (row == null || !Rows.Contains(row) || row.Agent != known[i]) coming.Add(known[i]);
                else
                {
                    row.At = i;
                    // If Python had lost it, or has never seen it, it begins.
                    if (!was[row.Number] && Started && (row.Told || !row.Came)) row.Born = true;
                    row.Came = true;
                }
            }
            // Those of a scene come in no order of theirs.
            if (coming.Count > 1)
            {
                var order = Everyone().ToList();
                coming = coming.OrderBy(agent => (uint)order.IndexOf(agent)).ToList();
            }
            foreach (var agent in coming)
            {
                if (refused.Contains(agent) || TryPlace(agent, loading, out var why)) continue;
                if (why == null) later = true;
                else if (!waited.Contains(agent)) waiting.Add(agent);
                else if (refused.Add(agent)) Refuse(agent, why);
            }
            Plan();
        }

        private bool TryPlace(IAgent agent, bool loading, out string why)
        {
            var given = Take(agent).Given;
            var (name, number) = AgentKind.Split(given);
            var kind = Kinds.Find(one => one.Name == name);
            why = kind == null
                ? $"agent '{given}' has come when Python was there, and there was none before: put one into the scene, "
                    + "which may be switched off"
                : Full(name, kind.Rows.Count);
            var row = kind?.Rows.Where(one => !one.Present && (number < 0 || one.Name == given))
                .OrderBy(one => Rank(one, loading)).FirstOrDefault();
            if (row == null) return false;
            if (!loading && row.Untold)
            {
                why = null;
                return false;
            }
            var state = agent.AgentState;
            kind.Check(agent);
            var before = row.State;
            // Its episode goes on with another agent, such as that of a scene that was loaded anew.
            var goesOn = loading && before != null && before != state && row.Came && row.Begun && !row.Told;
            (row.Agent, row.State) = (agent, state);
            state.Row = row;
            state.Call(row.Name);
            if (goesOn) state.GoOnFrom(before, row.BeganNow);
            row.At = known.IndexOf(agent);
            if (!goesOn && Started) row.Born = true;
            return row.Came = true;
        }

        // A row whose agent could come back is taken last; and one of which Python does not know that it has left only
        // where a scene was loaded anew.
        private int Rank(AgentRow row, bool loading) =>
            row.Agent == null || loading && !Exists(row.Agent) ? 0 : row.Untold ? 3 : Exists(row.Agent) ? 2 : 0;

        private AgentState Take(IAgent agent)
        {
            agent.AgentState.Tick = dt;
            return agent.AgentState;
        }

        private static string Full(string name, int most) => $"there are {most} agents of the name '{name}' already: "
            + $"raise At Most of '{name}' in GymManager, before Python comes";

        // Which sources each agent has, found once and not in each step.
        private void Plan()
        {
            foreach (var sensor in knownSensors) sensor.Place();
            var rows = Rows.ToDictionary(row => row.Name);
            var seen = Rows.ToDictionary(row => row, row => new List<Source>());
            foreach (var source in known.SelectMany(agent => agent.AgentState.Sources).Concat(knownSensors))
                foreach (var row in source.Locator.Mappings.Any(mapping => mapping.Everyone)
                    ? Rows.Where(row => source.Names(row.Name) && row.Kind.Located)
                    : source.Locator.Mappings.SelectMany(mapping => mapping.Agents).Distinct()
                        .Where(rows.ContainsKey).Select(name => rows[name]))
                {
                    if (!row.Kind.Located)
                        throw new MessageException("wrong-locator", $"{source.Name} goes into what {row.Name} sees, "
                            + "whose own Observe says that: leave out the one or the other");
                    seen[row].Add(source);
                }
            foreach (var row in Rows) row.Seen.Set(row.Name, seen[row]);
        }
    }
}
