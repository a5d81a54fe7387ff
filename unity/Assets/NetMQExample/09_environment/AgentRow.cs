// Lesson 09, rows: each agent that Python knows has one, in each request and in each answer.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using System.Text;

namespace NetMQExample
{
    /// <summary>The place of an agent in its kind: its name stays, also while nobody has it.</summary>
    internal sealed class AgentRow
    {
        public readonly AgentKind Kind;
        public readonly string Name;
        // Within its kind, and among all of the hello.
        public readonly int Place, Number;
        // Its sources, where it sees by attributes.
        public readonly SeenSources Seen = new SeenSources();
        // The agent that has it, or had it last; or null.
        public IAgent Agent;
        public AgentState State;
        // Its place in the list of those that take part; below 0: it has no part now.
        public int At = -1;
        // Whether its agent has been there at all, its episode has begun, and somebody has come who must begin.
        public bool Came, Begun, Born;
        // Whether Python knows that it is over, or that it has left; and whether its OnReset, which might have brought
        // it back, has not.
        public bool Told, StaysAway;
        // In this exchange: whether it has begun, is new in the answer, has its observation in it, and is in a section
        // of those that have ended.
        public bool BeganNow, New, Shown, Ended;
        // Its observation in the step of its end, and the form of that: others may have begun since, or it has left.
        public (byte[] Bytes, string Form) Last;
        // Python's order, the seed of its next episode, and whether it has an action, in real time
        // also one from before.
        public Order Order;
        public long Seed;
        public bool Acts;

        private readonly SpaceReader reader;
        private object tree, form;
        // In real time, an action that is done again and again.
        private ReadOnlyMemory<byte>? kept;

        public AgentRow(AgentKind kind, int place, int number, string name)
        {
            (Kind, Place, Number, Name) = (kind, place, number, name);
            reader = kind.Action == null ? null : new SpaceReader(kind.Action);
        }

        public bool Present => At >= 0;

        // Its episode goes on, for all that Python knows: it has not begun in this exchange, and is not to.
        public bool Untold => Came && Begun && !Told && !BeganNow && Order != Order.Reset;

        public bool Steps => Order == Order.Step || Order == Order.Last;

        // Whether it is there, in an episode, which may be over by now; and whether it ticks.
        public bool Plays => Present && Begun && !Born;

        public bool Lives => Plays && !State.Over;

        public void Read(ReadOnlyMemory<byte> action, object form, bool keep)
        {
            Acts = true;
            // The received bytes go with their message.
            if (keep) action = action.ToArray();
            kept = keep ? action : (ReadOnlyMemory<byte>?)null;
            this.form = form;
            if (reader == null) tree = Tree(action);
            else reader.Read(action);
        }

        /// <summary>Takes the action of somebody who plays by hand.</summary>
        public void Take(object action)
        {
            Acts = true;
            kept = null;
            if (reader == null) tree = action;
            else reader.Set(action);
        }

        public void Act()
        {
            // Read anew each time: an agent may change what it gets.
            if (kept is ReadOnlyMemory<byte> action)
            {
                if (reader == null) tree = Tree(action);
                else reader.Read(action);
            }
            if (reader != null) Agent.OnAction(reader);
            // Null: who plays it by hand presses nothing.
            else if (tree != null) Agent.OnAction(tree);
        }

        private object Tree(ReadOnlyMemory<byte> action) =>
            form == null ? MessageTree.Read(action) : MessageTree.Read(form, action);
    }

    /// <summary>Agents of one name, whose spaces are equal.</summary>
    internal sealed class AgentKind
    {
        public readonly string Name;
        // In the hello.
        public readonly int Place;
        public readonly int Period;
        public readonly GymSpace Observation, Action;
        public readonly List<AgentRow> Rows = new List<AgentRow>();
        // Whether Python asks for it in this request; and whether what is seen comes as locators and values, also where
        // C# says the space.
        public bool Asked, Located;

        private readonly SpaceWriter writer;

        /// <summary>The parts of fish_3.</summary>
        public static (string Name, int Number) Split(string name)
        {
            var at = name.LastIndexOf('_');
            var digits = name.Substring(at + 1);
            // 07 is a name, since row 7 is called 7.
            return at > 0 && (digits == "0" || !digits.StartsWith("0", StringComparison.Ordinal))
                && int.TryParse(digits, NumberStyles.None, CultureInfo.InvariantCulture, out var number)
                ? (name.Substring(0, at), number) : (name, -1);
        }

        public AgentKind(string name, int place, IAgent first)
        {
            (Name, Place, Period) = (name, place, first.AgentState.Period);
            (Observation, Action) = (first.Observation, first.Action);
            writer = Observation == null ? null : new SpaceWriter(Observation);
        }

        // How many bytes each observation has; below 0: that varies.
        public int Size => Located ? -1 : Observation.Size;

        /// <summary>Writes an observation, and returns its form, where it has one.</summary>
        public string Write(AgentRow row, FrameBuffer to)
        {
            var (last, form) = row.Last;
            row.Last = default;
            if (last != null) to.Write(last);
            else if (Located) form = row.Seen.Write(to);
            else
            {
                row.Agent.Observe(writer.Begin(to));
                writer.End();
            }
            return form;
        }

        public void Check(IAgent agent)
        {
            var what = agent.AgentState.Period != Period ? "period"
                : !Same(agent.Observation, Observation) ? "observation"
                : !Same(agent.Action, Action) ? "action" : null;
            if (what != null)
                throw new MessageException("two-kinds", $"'{agent.AgentState.Name}' and '{Rows[0].Name}' have one "
                    + $"name, {Name}, and not the same {what}: give them two names");
        }

        public object Describe() => new Dictionary<string, object>
        {
            ["name"] = Name,
            ["team"] = 0L,
            ["agents"] = Rows.Select(row => (object)row.Name).ToList(),
            ["at_most"] = (long)Rows.Count,
            ["period"] = (long)Period,
            ["observation"] = Observation?.Description,
            ["action"] = Action?.Description,
            ["located"] = Located,
            ["sensors"] = new List<object>(),
            ["branches"] = null,
            ["groups"] = false,
        };

        private static bool Same(GymSpace one, GymSpace other) => ReferenceEquals(one, other)
            || one != null && other != null && one.ToString() == other.ToString()
            && MessageTree.Write(one.Description).AsSpan().SequenceEqual(MessageTree.Write(other.Description));
    }

    // The sources of one agent, in the order of their locators: the whole of a thing before its parts, and the same on
    // every side. Its form changes seldom.
    internal sealed class SeenSources
    {
        private Source[] sources = new Source[0];
        private string[] keys = new string[0], forms = new string[0];
        private string whole;

        public void Set(string agent, IEnumerable<Source> all)
        {
            var own = all.Select(source => (Source: source, Text: source.For(agent)))
                .OrderBy(one => one.Text, StringComparer.Ordinal).ToArray();
            sources = Array.ConvertAll(own, one => one.Source);
            keys = Array.ConvertAll(own, one => $"[{MessageWriter.Quoted(one.Text)},");
            forms = new string[own.Length];
            whole = null;
        }

        /// <summary>Writes the numbers of all of them now, and returns their form.</summary>
        public string Write(FrameBuffer to)
        {
            var same = whole != null;
            for (var i = 0; i < sources.Length; i++)
            {
                var form = sources[i].Write(to, forms[i]);
                same &= ReferenceEquals(form, forms[i]) || form == forms[i];
                forms[i] = form;
            }
            if (same) return whole;
            var text = new StringBuilder("[");
            for (var i = 0; i < forms.Length; i++)
                text.Append(i > 0 ? "," : "").Append(keys[i]).Append(forms[i]).Append(']');
            return whole = text.Append(']').ToString();
        }
    }
}
