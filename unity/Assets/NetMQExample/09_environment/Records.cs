// Lesson 09, records: resets and steps as bytes, and the answers to them, each in one frame. In Python: records.py.
//
// All numbers are little-endian. Every part begins at a multiple of 8, with zeros before it.
//
//      0  uint8     3: a request, 4: an answer; a message of lesson 05 begins with {, which is 123
//      1  uint8     1: there is an exchange of side channels (lesson 13), 2: who ends begins anew within this exchange,
//                   4: the scene's clock, 8: real time, 16: all begin anew; the scene's clock only, and no sections
//      2  uint16    how many sections there are; 0 only by the scene's clock      4  uint32  0
//      8  int64     the id of the request, and of its answer
//     16  uint32    how many bytes of options or infos      20  uint32  how many bytes the exchange has
//     24            the options of a reset, or in an answer the world's own infos: a value (MessageTree.cs); the
//                   exchange; and the sections, one for each kind of agent, and with ENDED one more of those that ended
//
// A section has n rows, and row i is agent i of its kind, unless WHO says whose it is:
//
//      0  uint16    the kind, its place in the hello         2  uint16  columns, see below
//      4  uint32    n      8  uint32  i, how many infos      12  uint32  bytes of values     16  uint32  bytes of infos
//     20  uint32    0
//     24            of a request n int64, the seeds; of an answer n float64, the rewards
//                   n uint8, of a request 0 nothing, 1 step, 2 reset, 3 step and then your time is up; of an answer
//                   1 terminated + 2 truncated + 4 not there + 8 new + 16 wants an action + 32 has a row of values
//         WHO     1 n uint32
//         IDS     2 n int32, the agents' ids; of answers by the scene's clock only, as the next two are
//         GROUPS  4 n int32, groups, 0 is none, and n float32, their rewards
//         MASKS   8 uint32, how many choices a row has, and for each row so many uint8, 1: it is forbidden
//         SIZES  16 uint32 for each row of values: its size; without it all are of one size
//         FORM   32 uint32, how many bytes, and the form of all rows in ASCII: a row then has only its numbers. In any
//                   row of locators its own agent is not named: 'car'@['speed'] = $ is written @['speed'] = $
//         ENDED  64 these have ended in this exchange; never without WHO or IDS
//                   the values: an action for each that steps, or an observation for each mark with 32
//                   i pairs of uint32, row and size, and then the infos: values
using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;

namespace NetMQExample
{
    /// <summary>The order to one agent.</summary>
    public enum Order : byte
    {
        Nothing,
        Step,
        Reset,
        /// <summary>An action, after which its time is up.</summary>
        Last,
    }

    // The columns of a section.
    [Flags]
    internal enum Columns : ushort
    {
        None = 0, Who = 1, Ids = 2, Groups = 4, Masks = 8, Sizes = 16, Form = 32, Ended = 64,
    }

    // The marks of a row in an answer.
    [Flags]
    internal enum Marks : byte
    {
        None = 0, Terminated = 1, Truncated = 2, Absent = 4, New = 8, Wants = 16, Seen = 32,
    }

    /// <summary>A request, as it stands in a frame. It is read again and again, and then makes no garbage.</summary>
    public sealed class StepRequest
    {
        internal const int Head = 24;

        private readonly List<RequestSection> sections = new List<RequestSection>();
        private int orders;

        /// <summary>Its number, which the answer repeats.</summary>
        public long Id { get; private set; }

        /// <summary>Whether there is an exchange of side channels, perhaps an empty one.</summary>
        public bool HasExchange { get; private set; }

        /// <summary>Whether agents that end begin anew within this exchange.</summary>
        public bool Autoreset { get; private set; }

        /// <summary>Whether the scene itself says when Python is asked, as in ML-Agents.</summary>
        public bool SceneClock { get; private set; }

        /// <summary>Whether time passes by the clock.</summary>
        public bool RealTime { get; private set; }

        /// <summary>Whether all begin anew, by the scene's clock.</summary>
        public bool Resets { get; private set; }

        /// <summary>The options of a reset, a value, or nothing.</summary>
        public ReadOnlyMemory<byte> Options { get; private set; }

        /// <summary>The exchange of side channels.</summary>
        public ReadOnlyMemory<byte> Exchange { get; private set; }

        // One for each kind that is asked.
        internal int Count { get; private set; }

        internal RequestSection this[int at] => sections[at];

        /// <summary>Whether a frame is one, and no message of lesson 05. One of an older kit is one as well, which Read
        /// refuses.</summary>
        public static bool Is(ReadOnlySpan<byte> frame) =>
            frame.Length > 0 && (ByteOf(frame) == 3 || ByteOf(frame) == 1);

        /// <summary>Takes what stands in a frame, which must not change meanwhile.</summary>
        /// <exception cref="MessageException">It is no request.</exception>
        public void Read(ReadOnlyMemory<byte> frame)
        {
            var bytes = frame.Span;
            if (bytes.Length > Message.LimitBytes)
                throw new MessageException("too-big", $"a step has at most {Message.LimitBytes} bytes");
            if (bytes.Length > 0 && ByteOf(bytes) == 1)
                throw new MessageException("old-record",
                    "the other side speaks the record of an older kit: update the one that is older");
            if (!Is(bytes) || bytes.Length < Head) throw Bad("it ends too early");
            var bits = ByteOf(bytes.Slice(1));
            Count = BitConverter.ToUInt16(bytes.Slice(2));
            Id = BitConverter.ToInt64(bytes.Slice(8));
            long options = BitConverter.ToUInt32(bytes.Slice(16)), exchange = BitConverter.ToUInt32(bytes.Slice(20));
            // Only the scene's clock goes on without a word about anybody, and all that it resets are in one bit.
            var cannot = (bits & 4) == 0 ? Count == 0 || (bits & 16) != 0 : Count > 0 && (bits & 16) != 0;
            if (bits > 31 || cannot || BitConverter.ToUInt32(bytes.Slice(4)) != 0 || Id >> 53 != 0)
                throw Bad($"id {Id}, bits {bits} and {Count} sections cannot be");
            SceneClock = (bits & 4) != 0;
            HasExchange = (bits & 1) != 0;
            Autoreset = (bits & 2) != 0;
            RealTime = (bits & 8) != 0;
            Resets = (bits & 16) != 0;
            if (exchange > 0 && !HasExchange) throw Bad("it has an exchange that its bits deny");
            var begin = Head + Up(options);
            var at = begin + Up(exchange);
            if (at > bytes.Length) throw Bad("it ends too early");
            Options = frame.Slice(Head, (int)options);
            Exchange = frame.Slice((int)begin, (int)exchange);
            orders = 0;
            for (var i = 0; i < Count; i++)
            {
                if (sections.Count == i) sections.Add(new RequestSection());
                at = sections[i].Read(frame, at);
                orders |= sections[i].Orders;
            }
            if (at != bytes.Length) throw Bad($"it has {bytes.Length} bytes in place of {at}");
        }

        public bool Has(Order order) => (orders & 1 << (int)order) != 0;

        public bool Steps => Has(Order.Step) || Has(Order.Last);

        // Mono has no indexer of a ReadOnlySpan.
        internal static byte ByteOf(ReadOnlySpan<byte> bytes) => MemoryMarshal.Read<byte>(bytes);

        internal static long Up(long size) => (size + 7) & ~7L;

        internal static MessageException Bad(string why) =>
            new MessageException("bad-record", $"this is no reset and no step: {why}");
    }

    /// <summary>What is asked of the agents of one kind.</summary>
    internal sealed class RequestSection
    {
        private ReadOnlyMemory<byte> frame;
        private int[] begins = new int[0];
        private int begin;

        // The kind's place in the hello, and how many rows there are.
        public int Kind { get; private set; }

        public int Count { get; private set; }

        // A bit for each order that a row has.
        public int Orders { get; private set; }

        // Of all rows, or nothing.
        public ReadOnlyMemory<byte> Form { get; private set; }

        public Order OrderOf(int row) => (Order)StepRequest.ByteOf(frame.Span.Slice(begin + 8 * Count + row));
        public long Seed(int row) => BitConverter.ToInt64(frame.Span.Slice(begin + 8 * row));

        /// <summary>Its action; nothing for one that does not step.</summary>
        public ReadOnlyMemory<byte> Row(int row) => frame.Slice(begins[row], begins[row + 1] - begins[row]);

        /// <summary>Reads the section that begins there.</summary>
        /// <returns>Where it ends.</returns>
        public long Read(ReadOnlyMemory<byte> received, long from)
        {
            frame = received;
            if (from + 24 > frame.Length) throw Early();
            var head = frame.Span.Slice((int)from);
            Kind = BitConverter.ToUInt16(head);
            var columns = (Columns)BitConverter.ToUInt16(head.Slice(2));
            long count = BitConverter.ToUInt32(head.Slice(4)), values = BitConverter.ToUInt32(head.Slice(12));
            var infos = BitConverter.ToUInt32(head.Slice(8)) | BitConverter.ToUInt32(head.Slice(16))
                | BitConverter.ToUInt32(head.Slice(20));
            // Looked at before anything is made of it: a frame may claim thousands of millions.
            if (from + 24 + 9 * count + values > frame.Length) throw Early();
            const Columns Both = Columns.Sizes | Columns.Form;
            if (count == 0 || infos != 0 || (columns & ~Both) != 0 || columns == Both)
                throw StepRequest.Bad($"a section of {count} rows with columns {(int)columns} cannot be");
            var sized = (columns & Columns.Sizes) != 0;
            Count = (int)count;
            begin = (int)from + 24;
            var at = begin + 8 * count + StepRequest.Up(count);
            var acting = 0;
            Orders = 0;
            for (var row = 0; row < Count; row++)
            {
                if (OrderOf(row) > Order.Last) throw StepRequest.Bad($"order {(int)OrderOf(row)} is none");
                Orders |= 1 << (int)OrderOf(row);
                if (Acts(row)) acting++;
            }
            var sizes = (int)at;
            if (sized) at += StepRequest.Up(4L * acting);
            Form = default;
            if ((columns & Columns.Form) != 0)
            {
                if (at + 4 > frame.Length) throw Early();
                long size = BitConverter.ToUInt32(frame.Span.Slice((int)at));
                if (at + 4 + size > frame.Length) throw Early();
                Form = frame.Slice((int)at + 4, (int)size);
                at += StepRequest.Up(4 + size);
            }
            var end = at + StepRequest.Up(values);
            if (end > frame.Length) throw Early();
            if (acting == 0 ? values != 0 : !sized && values % acting != 0)
                throw StepRequest.Bad($"{values} bytes are no {acting} rows");
            // Where each row begins.
            if (begins.Length < Count + 1) begins = new int[Count + 1];
            var valuesEnd = at + values;
            for (var row = 0; row < Count && at <= valuesEnd; row++)
            {
                begins[row] = (int)at;
                if (!Acts(row)) continue;
                at += sized ? BitConverter.ToUInt32(frame.Span.Slice(sizes)) : values / acting;
                sizes += 4;
            }
            begins[Count] = (int)at;
            return at == valuesEnd ? end : throw StepRequest.Bad("its rows have other sizes");
        }

        private bool Acts(int row) => OrderOf(row) == Order.Step || OrderOf(row) == Order.Last;
        private static MessageException Early() => StepRequest.Bad("it ends too early");
    }
}
