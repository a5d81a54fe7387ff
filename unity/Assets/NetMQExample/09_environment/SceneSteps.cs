// Lesson 09, the order of a step.
//
//     1. OnAction of those that step, in the order of the rows.
//     2. For Step Period ticks, each agent's own: OnTick of all that are not over, then the world's, then physics.
//     3. OnStepped of those that step, then the world's.
//     4. OnReset of the world if all begin, and of those that begin, each with random numbers and options of its own.
//
// In Python it is scene/steps.py.
using System;
using System.Collections.Generic;
using System.Linq;

namespace NetMQExample
{
    /// <summary>The mover of a roster's agents, and of their world.</summary>
    internal sealed class SceneSteps
    {
        private static readonly IReadOnlyDictionary<string, object> None = new Dictionary<string, object>();
        private static readonly double[] NoState = new double[0];
        // Of agents that bring others in their OnReset.
        private const int MostRounds = 100;

        private readonly AgentRoster roster;
        private readonly double dt;
        private readonly List<AgentRow> acting = new List<AgentRow>(), beginning = new List<AgentRow>(),
            turn = new List<AgentRow>();

        public SceneSteps(AgentRoster roster, double dt)
        {
            this.roster = roster;
            this.dt = dt;
        }

        // It may be null.
        public IWorld World { get; set; }

        // One tick of whatever moves besides the agents and the world.
        public Action Physics { get; set; } = () => { };

        // Called when all begin because Python says so, before anything else.
        public Action Anew { get; set; } = () => { };

        /// <summary>A step of all that have an action; how many these are. In real time each tick is a step of
        /// everybody, with the last action.</summary>
        public int Step(bool real = false)
        {
            acting.Clear();
            foreach (var row in roster.Rows)
                if (row.Kind.Asked && (real ? row.Lives : row.Acts && row.Plays)) acting.Add(row);
            var ticks = real ? 1 : 0;
            foreach (var row in acting)
            {
                if (!row.Acts || !roster.IsThere(row)) continue;
                row.Act();
                if (!real) ticks = Math.Max(ticks, row.State.Period);
                row.Acts = real;
            }
            // Nothing after the end belongs to a step.
            for (var tick = 0; tick < ticks && IsAnyLeft(); tick++)
            {
                foreach (var row in roster.Rows)
                    if (row.Kind.Asked && row.Lives && tick < row.State.Period && roster.IsThere(row))
                        row.Agent.OnTick(dt);
                World?.OnTick(dt);
                Physics();
            }
            foreach (var row in acting) if (roster.IsThere(row)) row.Agent.OnStepped();
            World?.OnStepped();
            return acting.Count;
        }

        /// <summary>Begins the episodes of these, and of all that have come; how many these are. An OnReset may bring
        /// others, who have their turn then. The seed is the first agent's, of whom all of the world comes.</summary>
        public int Begin(Func<AgentRow, bool> again, ReadOnlyMemory<byte> options, long seed)
        {
            beginning.Clear();
            var told = false;
            // In each step a trainer of many resets those that are away, too. Their OnReset, which may bring them back,
            // is called in the first one.
            var inStep = roster.Rows.Exists(row => row.Steps);
            foreach (var row in roster.Rows)
            {
                if (!row.Kind.Asked || !again(row) || inStep && !row.Present && row.StaysAway) continue;
                beginning.Add(row);
                told |= row.Order == Order.Reset;
            }
            var all = beginning.Count > 0 && !roster.Rows.Any(row => row.Kind.Asked && row.Present && row.Begun
                && !beginning.Contains(row));
            if (all)
            {
                roster.Seed = unchecked(seed - roster.Rows.Find(row => row.Kind.Asked).Number);
                if (told) Anew();
                World?.OnReset(new RandomGenerator(seed), Copy(told ? options : default, 0, out _));
                roster.Settle(false);
            }
            var count = 0;
            for (var round = 0; round < MostRounds; round++)
            {
                turn.Clear();
                foreach (var row in roster.Rows)
                    if (row.Kind.Asked && (row.Born && row.Present || beginning.Count > 0 && beginning.Contains(row)
                        && row.Agent != null && row.Came && roster.Exists(row.Agent))) turn.Add(row);
                if (turn.Count == 0) break;
                foreach (var row in turn) Begin(row, beginning.Remove(row), options);
                foreach (var row in turn)
                {
                    row.Agent.OnReset();
                    // Rewards before its first step belong to none.
                    row.State.Take();
                }
                count += turn.Count;
                roster.Settle(false);
            }
            return count;
        }

        private void Begin(AgentRow row, bool again, ReadOnlyMemory<byte> options)
        {
            var told = again && row.Order == Order.Reset;
            // An agent that begins by itself begins without options.
            var own = Copy(told ? options : default, row.State.StateSize, out var state);
            var seed = again ? row.Seed : unchecked(roster.Seed + row.Number);
            row.State.Begin(new RandomGenerator(seed), own, state);
            row.Begun = row.BeganNow = roster.Started = true;
            row.Born = row.Told = false;
            row.StaysAway = !row.Present;
            row.New = !told;
        }

        /// <summary>Options as one agent gets them.</summary>
        /// <exception cref="MessageException">The state in which an episode begins is none.</exception>
        public static IReadOnlyDictionary<string, object> Copy(
            ReadOnlyMemory<byte> options, int size, out double[] state)
        {
            state = NoState;
            if (options.Length == 0) return None;
            var copy = MessageTree.Read(options) as Dictionary<string, object>
                ?? throw new MessageException("bad-options", "options are a dict");
            if (size > 0 && copy.Remove("state", out var given)) state = State(given, size);
            return copy;
        }

        private static double[] State(object given, int size)
        {
            var array = given as MessageArray;
            var list = given as List<object>;
            // Counted before they are converted: a message may have millions.
            var length = array != null ? array.Data.Length / MessageArray.SizeOf(array.Dtype) : list?.Count ?? 0;
            if (length != 0 && length != size)
                throw new MessageException("bad-state", $"a state is {size} numbers, not {length}");
            return array != null ? SpaceNumbers.Of(array)
                : list != null && list.All(one => one is long || one is double)
                    ? list.Select(Convert.ToDouble).ToArray()
                : throw new MessageException("bad-state", "a state is numbers");
        }

        private bool IsAnyLeft()
        {
            foreach (var row in acting) if (!row.State.Over) return true;
            return false;
        }
    }
}
