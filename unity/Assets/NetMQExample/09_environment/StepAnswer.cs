// Lesson 09, the answer to a reset or a step, as Records.cs says.
using System;
using System.Collections.Generic;

namespace NetMQExample
{
    /// <summary>It is written again and again, and then makes no garbage.</summary>
    public sealed class StepAnswer
    {
        private readonly FrameBuffer ended = new FrameBuffer(), infos = new FrameBuffer(), table = new FrameBuffer(),
            whole = new FrameBuffer(), now = new FrameBuffer();
        private long id;
        private int sections;
        // Of the section that is being written: its buffer, and where its parts begin.
        private FrameBuffer to;
        private int head, marks, sizes, values;

        // A value for all, or null.
        internal byte[] Infos { get; set; }

        // Whether it is one of the scene's clock.
        internal bool SceneClock { get; set; }

        /// <summary>The messages of the side channels; null: there are none.</summary>
        public byte[] Exchange { get; set; }

        /// <summary>All of it, until the next answer begins.</summary>
        public ReadOnlyMemory<byte> Frame()
        {
            now.Write(ended.From(0).Span);
            var frame = now;
            if (Infos != null || Exchange != null)
            {
                frame = whole;
                whole.Clear();
                whole.Reserve(StepRequest.Head);
                whole.Write(Infos.AsSpan());
                whole.Pad();
                whole.Write(Exchange.AsSpan());
                whole.Pad();
                whole.Write(now.From(StepRequest.Head).Span);
            }
            if (frame.Count > Message.LimitBytes)
                throw new MessageException("too-big", $"an answer has at most {Message.LimitBytes} bytes");
            var first = frame.At(0);
            first[0] = 4;
            first[1] = (byte)((Exchange == null ? 0 : 1) | (SceneClock ? 4 : 0));
            BitConverter.TryWriteBytes(first.Slice(2), (ushort)sections);
            BitConverter.TryWriteBytes(first.Slice(8), id);
            BitConverter.TryWriteBytes(first.Slice(16), (uint)(Infos?.Length ?? 0));
            BitConverter.TryWriteBytes(first.Slice(20), (uint)(Exchange?.Length ?? 0));
            return frame.From(0);
        }

        internal void Begin(long of)
        {
            id = of;
            sections = 0;
            SceneClock = false;
            Infos = null;
            Exchange = null;
            ended.Clear();
            now.Clear();
            now.Reserve(StepRequest.Head);
        }

        internal void BeginSection(int kind, int rows, Columns columns)
        {
            // By Python's clock they come last, since an answer begins with those that were asked.
            to = (columns & Columns.Ended) != 0 && !SceneClock ? ended : now;
            sections++;
            head = to.Reserve(24);
            BitConverter.TryWriteBytes(to.At(head), (ushort)kind);
            BitConverter.TryWriteBytes(to.At(head + 2), (ushort)columns);
            BitConverter.TryWriteBytes(to.At(head + 4), (uint)rows);
            to.Reserve(8 * rows);
            marks = to.Reserve(rows);
            to.Pad();
            infos.Clear();
            table.Clear();
        }

        // For each row, before anything else.
        internal void Who(int place) => to.Write((uint)place);

        /// <summary>Begins a column but Who, in their order: what is written into what is returned.</summary>
        internal FrameBuffer BeginColumn()
        {
            to.Pad();
            return to;
        }

        internal void Set(int row, double reward, Marks mark, Dictionary<string, object> info)
        {
            BitConverter.TryWriteBytes(to.At(head + 24 + 8 * row), reward);
            to.At(marks + row)[0] = (byte)mark;
            if (info == null) return;
            var before = infos.Count;
            MessageTree.Write(infos, info);
            table.Write((uint)row);
            table.Write((uint)(infos.Count - before));
        }

        /// <summary>Begins the values of so many rows, which are written into what is returned: each has a size of its
        /// own, which Size says; or all have one form; or neither.</summary>
        internal FrameBuffer BeginValues(int rows, bool sized, byte[] form = null)
        {
            if (sized) sizes = to.Reserve(4 * rows);
            if (form != null)
            {
                to.Pad();
                to.Write((uint)form.Length);
                to.Write(form);
            }
            to.Pad();
            values = to.Count;
            if (sized || form != null) to.At(head + 2)[0] |= (byte)(sized ? Columns.Sizes : Columns.Form);
            return to;
        }

        internal void Size(int row, int size) => BitConverter.TryWriteBytes(to.At(sizes + 4 * row), (uint)size);

        internal void EndSection()
        {
            BitConverter.TryWriteBytes(to.At(head + 8), (uint)(table.Count / 8));
            BitConverter.TryWriteBytes(to.At(head + 12), (uint)(to.Count - values));
            BitConverter.TryWriteBytes(to.At(head + 16), (uint)infos.Count);
            to.Pad();
            to.Write(table.From(0).Span);
            to.Write(infos.From(0).Span);
            to.Pad();
        }
    }
}
