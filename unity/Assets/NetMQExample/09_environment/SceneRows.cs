// Lesson 09, the rows of a request, and those of its answer, as Records.cs says. In Python: scene/exchange.py.
using System.Collections.Generic;
using System.Text;

namespace NetMQExample
{
    /// <summary>Reads what is asked of the agents of a roster, and writes what is known of them.</summary>
    internal sealed class SceneRows
    {
        private readonly AgentRoster roster;
        private readonly List<AgentRow> shown = new List<AgentRow>();
        private readonly FrameBuffer scratch = new FrameBuffer();
        private int[] ends = new int[0];
        private string[] forms = new string[0];
        private string form = "";
        private byte[] formBytes = new byte[0];

        public SceneRows(AgentRoster roster) => this.roster = roster;

        /// <summary>Takes a request, and checks all of it.</summary>
        public void Ask(StepRequest request, bool real)
        {
            foreach (var kind in roster.Kinds) kind.Asked = false;
            foreach (var row in roster.Rows)
            {
                row.Order = Order.Nothing;
                row.New = row.BeganNow = row.Shown = row.Ended = false;
                row.Acts &= real;
                row.Last = default;
            }
            for (var i = 0; i < request.Count; i++) Ask(request, request[i]);
        }

        /// <summary>Whether those are there who began in this exchange, or were there when it began.</summary>
        public bool AreThere()
        {
            roster.Settle(true);
            foreach (var row in roster.Rows)
                if (!row.Present && (row.BeganNow || row.Steps && row.Begun)) return false;
            return true;
        }

        /// <summary>The world's own picture, or one of each row: an agent that is away, or draws nothing, is black.
        /// Null: nobody draws any.</summary>
        public IEnumerable<MessageArray> Pictures(MessageArray world)
        {
            if (world != null) return new[] { world };
            var each = roster.Rows.ConvertAll(row => row.Present ? row.Agent.Render() : null);
            var drawn = each.Find(one => one != null);
            return drawn == null ? null : each.ConvertAll(
                one => one ?? new MessageArray(drawn.Dtype, new byte[drawn.Data.Length], drawn.Shape));
        }

        private void Ask(StepRequest request, RequestSection section)
        {
            var kind = section.Kind < roster.Kinds.Count ? roster.Kinds[section.Kind] : null;
            if (kind == null || kind.Asked)
                throw new MessageException("wrong-agents",
                    $"kind {section.Kind} is none, or asked for twice: there are {roster.Kinds.Count}");
            if (section.Count != kind.Rows.Count)
                throw new MessageException("wrong-agents",
                    $"{section.Count} rows, but there are {kind.Rows.Count} agents of {kind.Name}");
            kind.Asked = true;
            var shape = section.Form.Length > 0 && kind.Action == null ? MessageTree.Form(section.Form) : null;
            var first = true;
            for (var i = 0; i < section.Count; i++)
            {
                var row = kind.Rows[i];
                row.Order = section.OrderOf(i);
                row.Seed = section.Seed(i);
                if (row.Steps && row.Present && !row.Begun && !row.Born)
                    throw new MessageException("wrong-agents",
                        $"{row.Name} is over, or has not begun: reset comes first");
                // One that has left does not act, and the answer says so.
                if (row.Steps && row.Plays) row.Read(section.Row(i), shape, request.RealTime);
                if (row.Order != Order.Reset || !first) continue;
                first = false;
                // What is wrong with them is said before anything moves.
                SceneSteps.Copy(request.Options, row.State?.StateSize ?? 0, out _);
            }
        }

        /// <summary>An agent that leaves in the step of its end, or in its last one, is seen in it: a frame later it
        /// may be gone.</summary>
        public void SeeLeaving()
        {
            foreach (var row in roster.Rows)
                if (row.Steps && row.Plays && (row.State.Over || row.Order == Order.Last) && !roster.IsThere(row))
                    row.Last = One(row);
        }

        /// <summary>Those that have ended are seen a last time, and with the autoreset said to have.</summary>
        public void End(AgentKind kind, bool autoreset, StepAnswer answer)
        {
            shown.Clear();
            foreach (var row in kind.Rows)
            {
                if (!row.Steps || !row.Begun || !row.Present && row.Last.Bytes == null) continue;
                if (row.Order == Order.Last) row.State.Truncate();
                row.Ended = row.State.Over;
                if (row.Ended) shown.Add(row);
            }
            if (shown.Count == 0) return;
            // Before others begin, which might change what it sees.
            if (!autoreset)
                foreach (var row in shown) row.Last = row.Last.Bytes == null ? One(row) : row.Last;
            else WriteEnded(kind, answer);
        }

        private void WriteEnded(AgentKind kind, StepAnswer answer)
        {
            answer.BeginSection(kind.Place, shown.Count, Columns.Who | Columns.Ended);
            foreach (var row in shown) answer.Who(row.Place);
            Write(kind, answer);
            for (var i = 0; i < shown.Count; i++)
            {
                var (reward, ends) = shown[i].State.Take();
                answer.Set(i, reward, (Marks)ends | Marks.Seen, shown[i].State.TakeInfo());
                shown[i].State.ForgetInfo();
                shown[i].Told = true;
                shown[i].Begun = false;
            }
            answer.EndSection();
        }

        public void See(AgentKind kind, StepAnswer answer)
        {
            answer.BeginSection(kind.Place, kind.Rows.Count, Columns.None);
            shown.Clear();
            foreach (var row in kind.Rows)
            {
                row.Shown = row.Present ? row.Order != Order.Nothing || row.New : row.Last.Bytes != null;
                if (row.Shown) shown.Add(row);
            }
            Write(kind, answer);
            foreach (var row in kind.Rows)
            {
                if (!row.Present || row.Order != Order.Nothing || row.New) Tell(row, answer);
                row.Order = Order.Nothing;
                row.BeganNow = false;
            }
            answer.EndSection();
        }

        // What is said of a row: its reward, its marks, and its infos.
        private static void Tell(AgentRow row, StepAnswer answer)
        {
            var (reward, ends) = row.State?.Take() ?? (0, 0);
            // Told once. An end in an OnReset, or while others are seen, belongs to the next step.
            if (!row.Begun || row.New || row.Present && !row.Ended) ends = 0;
            // While it is away nothing that others do to it counts.
            if (!row.Begun) reward = 0;
            var mark = (Marks)ends | (row.Present ? 0 : Marks.Absent) | (row.Shown ? Marks.Seen : 0);
            if (row.Present && row.New) mark |= Marks.New;
            row.Told = !row.Present || ends != 0;
            // From now on it must be reset.
            if (row.Told) row.Begun = false;
            answer.Set(row.Place, reward, mark, row.State?.TakeInfo());
            row.State?.ForgetInfo();
        }

        // The observations of those shown: numbers of one size right into the answer, and all else once it is known how
        // it differs.
        private void Write(AgentKind kind, StepAnswer answer)
        {
            if (kind.Size >= 0 || shown.Count == 0)
            {
                var to = answer.BeginValues(shown.Count, false);
                foreach (var row in shown) kind.Write(row, to);
                return;
            }
            if (ends.Length < shown.Count) (ends, forms) = (new int[shown.Count], new string[shown.Count]);
            scratch.Clear();
            var alike = true;
            for (var i = 0; i < shown.Count; i++)
            {
                forms[i] = kind.Write(shown[i], scratch);
                ends[i] = scratch.Count;
                alike &= Size(i) == Size(0) && (ReferenceEquals(forms[i], forms[0]) || forms[i] == forms[0]);
            }
            if (alike) answer.BeginValues(shown.Count, false, kind.Located ? BytesOf(forms[0]) : null)
                .Write(scratch.From(0).Span);
            else WriteEach(kind, answer);
        }

        // The observation of one agent, as it is now.
        private (byte[] Bytes, string Form) One(AgentRow row)
        {
            scratch.Clear();
            var its = row.Kind.Write(row, scratch);
            return (scratch.From(0).ToArray(), its);
        }

        private int Size(int row) => ends[row] - (row == 0 ? 0 : ends[row - 1]);

        private void WriteEach(AgentKind kind, StepAnswer answer)
        {
            int Whole(int row) => Size(row) + (kind.Located ? 4 + forms[row].Length : 0);
            var sized = false;
            for (var i = 0; i < shown.Count; i++) sized |= Whole(i) != Whole(0);
            var to = answer.BeginValues(shown.Count, sized);
            for (var i = 0; i < shown.Count; i++)
            {
                if (sized) answer.Size(i, Whole(i));
                if (kind.Located) MessageParts.WriteText(to, forms[i]);
                to.Write(scratch.From(0).Span.Slice(ends[i] - Size(i), Size(i)));
            }
        }

        // Most have the same form from step to step.
        private byte[] BytesOf(string text)
        {
            if (ReferenceEquals(text, form)) return formBytes;
            form = text;
            return formBytes = Encoding.ASCII.GetBytes(text);
        }
    }
}
