// Lesson 09, the observations of one kind, as they stand in an answer (Records.cs).
using System;
using System.Collections.Generic;
using System.Text;

namespace NetMQExample
{
    /// <summary>Writes them: numbers of one size right into the answer, and all else once it is known how it differs.
    /// </summary>
    internal sealed class SeenRows
    {
        private readonly FrameBuffer scratch = new FrameBuffer();
        private int[] ends = new int[0];
        private string[] forms = new string[0];
        private string form = "";
        private byte[] formBytes = new byte[0];

        /// <summary>The observations of these agents of a kind.</summary>
        public void Write(AgentKind kind, List<AgentRow> rows, StepAnswer answer)
        {
            if (kind.Size >= 0 || rows.Count == 0)
            {
                var to = answer.BeginValues(rows.Count, false);
                foreach (var row in rows) kind.Write(row, to);
                return;
            }
            if (ends.Length < rows.Count) (ends, forms) = (new int[rows.Count], new string[rows.Count]);
            scratch.Clear();
            var alike = true;
            for (var i = 0; i < rows.Count; i++)
            {
                forms[i] = kind.Write(rows[i], scratch);
                ends[i] = scratch.Count;
                alike &= Size(i) == Size(0) && (ReferenceEquals(forms[i], forms[0]) || forms[i] == forms[0]);
            }
            if (alike) answer.BeginValues(rows.Count, false, kind.Located ? BytesOf(forms[0]) : null)
                .Write(scratch.From(0).Span);
            else WriteEach(kind, rows.Count, answer);
        }

        /// <summary>The observation of one agent, as it is now.</summary>
        public (byte[] Bytes, string Form) One(AgentRow row)
        {
            scratch.Clear();
            var its = row.Kind.Write(row, scratch);
            return (scratch.From(0).ToArray(), its);
        }

        private int Size(int row) => ends[row] - (row == 0 ? 0 : ends[row - 1]);

        private void WriteEach(AgentKind kind, int count, StepAnswer answer)
        {
            int Whole(int row) => Size(row) + (kind.Located ? 4 + forms[row].Length : 0);
            var sized = false;
            for (var i = 0; i < count; i++) sized |= Whole(i) != Whole(0);
            var to = answer.BeginValues(count, sized);
            for (var i = 0; i < count; i++)
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
