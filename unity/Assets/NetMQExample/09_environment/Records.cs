// Lesson 09, records: resets and steps as bytes, and the answers to them, each in one frame. In Python: records.py.
//
// All numbers are little-endian; n is how many there are, areas or agents, each of which has a row.
//
//     0            uint8       1: a request, 2: an answer; a message of lesson 05 begins with {, which is 123
//     1            uint8       1: there is an exchange of side channels (lesson 13), else 0
//     2            uint16      0
//     4            uint32      n
//     8            int64       the id of the request, and of its answer
//     16           uint32      how many bytes of options there are
//     20           uint32      how many bytes the exchange has
//     24           n * 8       of a request the seeds, int64; of an answer the rewards, float64
//     24 + 8 n     n * 4       uint32, how many bytes each row has
//     24 + 12 n    n * 4       uint32, how many bytes each info has
//     24 + 16 n    n           uint8: of a request 0 nothing, 1 step, 2 reset; of an answer 1 terminated + 2 truncated,
//                              or 4, this agent is not there
//     24 + 17 n                the options, the exchange, the rows, the infos
//
// A row is an action or an observation, as its space says (GymSpace.cs). Options are those of a reset, or in an answer
// what is told to all; infos are those of a step. Both are values (MessageTree.cs), or empty. A request has a row for
// each that steps, an answer for each that is there.
using System;
using System.Buffers;
using System.Collections.Generic;
using System.Runtime.InteropServices;

namespace NetMQExample
{
    /// <summary>The order to one area or agent.</summary>
    public enum Order : byte
    {
        /// <summary>It has no part in this.</summary>
        Nothing,

        /// <summary>An action.</summary>
        Step,

        /// <summary>A new episode.</summary>
        Reset,
    }

    /// <summary>A request, as it stands in a frame. It is read again and again, and then makes no garbage.</summary>
    public sealed class StepRequest
    {
        private const int Head = 24, Each = 17;

        private ReadOnlyMemory<byte> frame;
        private int[] begins = new int[0];

        /// <summary>How many areas or agents there are.</summary>
        public int Count { get; private set; }

        /// <summary>Its number, which the answer repeats.</summary>
        public long Id { get; private set; }

        /// <summary>Whether there is an exchange of side channels, perhaps an empty one.</summary>
        public bool HasExchange { get; private set; }

        /// <summary>The options of a reset, a value, or nothing.</summary>
        public ReadOnlyMemory<byte> Options { get; private set; }

        /// <summary>The exchange of side channels.</summary>
        public ReadOnlyMemory<byte> Exchange { get; private set; }

        /// <summary>Whether a frame is one, and no message of lesson 05.</summary>
        public static bool Is(ReadOnlySpan<byte> frame) => frame.Length > 0 && ByteOf(frame) == 1;

        /// <summary>Takes what stands in a frame, which must not change meanwhile.</summary>
        /// <exception cref="MessageException">It is no request.</exception>
        public void Read(ReadOnlyMemory<byte> received)
        {
            frame = received;
            var bytes = received.Span;
            if (bytes.Length > Message.LimitBytes)
                throw new MessageException("too-big", $"a step has at most {Message.LimitBytes} bytes");
            if (!Is(bytes) || bytes.Length < Head) throw Bad("it ends too early");
            var count = BitConverter.ToUInt32(bytes.Slice(4));
            Id = BitConverter.ToInt64(bytes.Slice(8));
            HasExchange = (ByteOf(bytes.Slice(1)) & 1) != 0;
            if (count == 0 || Head + (long)Each * count > bytes.Length || Id >> 53 != 0)
                throw Bad($"id {Id} and {count} rows cannot be");
            Count = (int)count;
            if (begins.Length < Count + 1) begins = new int[Count + 1];
            long options = BitConverter.ToUInt32(bytes.Slice(16)), exchange = BitConverter.ToUInt32(bytes.Slice(20));
            var at = Head + (long)Each * Count + options + exchange;
            for (var row = 0; row < Count; row++)
            {
                if (Mark(row) > (byte)Order.Reset) throw Bad($"order {Mark(row)} is none");
                begins[row] = (int)Math.Min(at, bytes.Length);
                at += BitConverter.ToUInt32(bytes.Slice(Head + 8 * Count + 4 * row));
            }
            begins[Count] = (int)Math.Min(at, bytes.Length);
            for (var row = 0; row < Count; row++) at += BitConverter.ToUInt32(bytes.Slice(Head + 12 * Count + 4 * row));
            if (at != bytes.Length) throw Bad($"it has {bytes.Length} bytes in place of {at}");
            Options = frame.Slice(Head + Each * Count, (int)options);
            Exchange = frame.Slice(Head + Each * Count + (int)options, (int)exchange);
        }

        /// <summary>The order to this one.</summary>
        public Order OrderOf(int row) => (Order)Mark(row);

        /// <summary>Whether any has this order.</summary>
        public bool Has(Order order)
        {
            for (var row = 0; row < Count; row++) if (OrderOf(row) == order) return true;
            return false;
        }

        /// <summary>The seed of its next episode.</summary>
        public long Seed(int row) => BitConverter.ToInt64(frame.Span.Slice(Head + 8 * row));

        /// <summary>Its action.</summary>
        public ReadOnlyMemory<byte> Row(int row) => frame.Slice(begins[row], begins[row + 1] - begins[row]);

        /// <summary>The options of a reset, by name.</summary>
        /// <exception cref="MessageException">They are none.</exception>
        public Dictionary<string, object> ReadOptions()
        {
            if (Options.Length == 0) return new Dictionary<string, object>();
            return MessageTree.Read(Options) as Dictionary<string, object>
                ?? throw new MessageException("bad-options", "options are a dict");
        }

        // Mono has no indexer of a ReadOnlySpan.
        internal static byte ByteOf(ReadOnlySpan<byte> bytes) => MemoryMarshal.Read<byte>(bytes);

        private byte Mark(int row) => ByteOf(frame.Span.Slice(Head + 16 * Count + row));

        private static MessageException Bad(string why) =>
            new MessageException("bad-record", $"this is no reset and no step: {why}");
    }

    /// <summary>The answer to a request. It is written again and again, and then makes no garbage.</summary>
    public sealed class StepAnswer
    {
        private readonly ArrayBufferWriter<byte> infos = new ArrayBufferWriter<byte>();
        private readonly ArrayBufferWriter<byte> whole = new ArrayBufferWriter<byte>();
        private double[] rewards = new double[0];
        private int[] sizes = new int[0];
        private byte[] ends = new byte[0];
        private long id;
        private int count, rowsBefore, infosBefore;

        /// <summary>The observations, row after row: write one, then call EndRow.</summary>
        public ArrayBufferWriter<byte> Rows { get; } = new ArrayBufferWriter<byte>();

        /// <summary>A value for all; null: none.</summary>
        public byte[] Options { get; set; }

        /// <summary>The messages of the side channels; null: there are none.</summary>
        public byte[] Exchange { get; set; }

        /// <summary>Begins the answer to a request.</summary>
        public void Begin(StepRequest request)
        {
            if (rewards.Length < request.Count)
            {
                rewards = new double[request.Count];
                ends = new byte[request.Count];
                sizes = new int[2 * request.Count];
            }
            id = request.Id;
            count = 0;
            Rows.Clear();
            infos.Clear();
            Options = null;
            Exchange = null;
            rowsBefore = infosBefore = 0;
        }

        /// <summary>Ends the row of the next one.</summary>
        /// <param name="who">For a person who must mend something.</param>
        /// <param name="verdict">The step's reward, and whether the episode is over.</param>
        /// <param name="info">More for Python; null or empty: nothing.</param>
        /// <exception cref="MessageException">The reward is no number.</exception>
        public void EndRow(string who, (double Reward, bool Terminated, bool Truncated) verdict,
            IReadOnlyDictionary<string, object> info = null)
        {
            if (double.IsNaN(verdict.Reward) || double.IsInfinity(verdict.Reward))
                throw new MessageException("bad-reward",
                    FormattableString.Invariant($"the reward of {who} is {verdict.Reward}"));
            rewards[count] = verdict.Reward;
            EndRow(Ends(verdict), info);
        }

        /// <summary>The next one had no part in this.</summary>
        public void SkipRow()
        {
            rewards[count] = 0;
            EndRow(0, null);
        }

        /// <summary>The next one is not there any more: nothing is seen of it.</summary>
        /// <param name="verdict">Its reward until it left, and whether its episode was over by then.</param>
        /// <param name="info">The infos that it has sent until then.</param>
        public void EndAbsent((double Reward, bool Terminated, bool Truncated) verdict,
            IReadOnlyDictionary<string, object> info)
        {
            rewards[count] = verdict.Reward;
            EndRow((byte)(4 | Ends(verdict)), info);
        }

        /// <summary>All of it, until the next answer begins.</summary>
        public ReadOnlyMemory<byte> Frame()
        {
            whole.Clear();
            var head = whole.GetSpan(24);
            head.Slice(0, 24).Clear();
            head[0] = 2;
            head[1] = (byte)(Exchange == null ? 0 : 1);
            BitConverter.TryWriteBytes(head.Slice(4), (uint)count);
            BitConverter.TryWriteBytes(head.Slice(8), id);
            BitConverter.TryWriteBytes(head.Slice(16), (uint)(Options?.Length ?? 0));
            BitConverter.TryWriteBytes(head.Slice(20), (uint)(Exchange?.Length ?? 0));
            whole.Advance(24);
            whole.Write(MemoryMarshal.AsBytes<double>(rewards.AsSpan(0, count)));
            // The rows' sizes, and then the infos'.
            whole.Write(MemoryMarshal.AsBytes<int>(sizes.AsSpan(0, count)));
            whole.Write(MemoryMarshal.AsBytes<int>(sizes.AsSpan(rewards.Length, count)));
            whole.Write(ends.AsSpan(0, count));
            whole.Write(Options.AsSpan());
            whole.Write(Exchange.AsSpan());
            whole.Write(Rows.WrittenSpan);
            whole.Write(infos.WrittenSpan);
            if (whole.WrittenCount > Message.LimitBytes)
                throw new MessageException("too-big", $"an answer has at most {Message.LimitBytes} bytes");
            return whole.WrittenMemory;
        }

        private static byte Ends((double Reward, bool Terminated, bool Truncated) verdict) =>
            (byte)((verdict.Terminated ? 1 : 0) | (verdict.Truncated ? 2 : 0));

        private void EndRow(byte end, IReadOnlyDictionary<string, object> info)
        {
            if (info != null && info.Count > 0) MessageTree.Write(infos, info);
            ends[count] = end;
            sizes[count] = Rows.WrittenCount - rowsBefore;
            sizes[rewards.Length + count] = infos.WrittenCount - infosBefore;
            rowsBefore = Rows.WrittenCount;
            infosBefore = infos.WrittenCount;
            count++;
        }
    }
}
