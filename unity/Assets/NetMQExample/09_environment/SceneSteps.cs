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
    /// <summary>What moves the agents of a roster, and their world.</summary>
    internal sealed class SceneSteps
    {
        private static readonly IReadOnlyDictionary<string, object> None = new Dictionary<string, object>();
        private static readonly double[] NoState = new double[0];

        private readonly AgentRoster roster;
        private readonly double dt;
        private readonly List<AgentRow> acting = new List<AgentRow>(), beginning = new List<AgentRow>();

        public SceneSteps(AgentRoster roster, double dt)
        {
            this.roster = roster;
            this.dt = dt;
        }

        /// <summary>What belongs to no agent; or null.</summary>
        public IWorld World { get; set; }

        /// <summary>One tick of whatever moves besides the agents and the world.</summary>
        public Action Physics { get; set; } = () => { };

        /// <summary>How many episodes were begun.</summary>
        public int Episodes { get; private set; }

        /// <summary>A step of all that have an action.</summary>
        /// <param name="real">Whether an action is for each step until the next one comes.</param>
        public void Step(bool real = false)
        {
            acting.Clear();
            foreach (var row in roster.Rows) if (row.Acts && row.Lives) acting.Add(row);
            var ticks = 0;
            foreach (var row in acting)
            {
                if (!roster.IsThere(row)) continue;
                row.Act();
                ticks = Math.Max(ticks, row.State.Period);
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
            foreach (var row in acting)
            {
                if (roster.IsThere(row)) row.Agent.OnStepped();
                if (row.Order == Order.Last && !row.State.Over) row.State.Truncate();
                row.Acts &= real;
            }
            World?.OnStepped();
        }

        /// <summary>Begins episodes.</summary>
        /// <param name="begins">Of these, as soon as their agents are there: an OnReset may bring others back.</param>
        /// <param name="options">Of each of them, a copy.</param>
        public void Begin(Func<AgentRow, bool> begins, ReadOnlyMemory<byte> options)
        {
            beginning.Clear();
            foreach (var row in roster.Rows) if (row.Kind.Asked && begins(row)) beginning.Add(row);
            if (beginning.Count == 0) return;
            var first = beginning.Find(row => !row.Born);
            if (World != null && first != null && !roster.Rows.Any(row =>
                row.Kind.Asked && row.Present && (row.Lives || row.Steps) && !beginning.Contains(row)))
                World.OnReset(new RandomGenerator(first.Seed - first.Number),
                    Copy(first.Order == Order.Reset ? options : default, 0, out _));
            while (true)
            {
                var now = beginning.Where(row => row.Agent != null && row.Came && roster.Exists(row.Agent)).ToList();
                if (now.Count == 0) return;
                foreach (var row in now)
                {
                    // Who begins by itself begins without options.
                    var own = Copy(row.Order == Order.Reset ? options : default, row.State.StateSize, out var state);
                    row.State.Begin(new RandomGenerator(row.Seed), own, state);
                    row.Begun = row.BeganNow = roster.Started = true;
                    row.Born = row.Told = false;
                    beginning.Remove(row);
                }
                foreach (var row in now) row.Agent.OnReset();
                Episodes += now.Count;
                if (beginning.Count > 0) roster.Settle(false);
            }
        }

        /// <summary>Options as one agent gets them.</summary>
        /// <exception cref="MessageException">The state in which an episode begins is none.</exception>
        public static IReadOnlyDictionary<string, object> Copy(ReadOnlyMemory<byte> options, int size, out double[] state)
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
