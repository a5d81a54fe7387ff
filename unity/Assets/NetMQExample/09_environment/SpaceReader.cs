// Lesson 09, an action: what Python wants, as numbers or as a value of any space.
using System;
using System.Collections.Generic;

namespace NetMQExample
{
    /// <summary>Something of a space, as Python has sent it. It is used again for the next one.</summary>
    public sealed class SpaceReader
    {
        private readonly GymSpace space;
        private readonly double[] numbers;
        private readonly SpaceNumbers[] parts;
        private ReadOnlyMemory<byte> row;
        private object value;

        public SpaceReader(GymSpace space)
        {
            this.space = Require.Given("space", space);
            numbers = new double[Math.Max(0, space.Count)];
            parts = space.AllNumbers;
        }

        /// <summary>How many numbers it has, of all parts of its space together; 0 where that varies.</summary>
        public int Count => numbers.Length;

        /// <summary>One of its numbers; of a discrete space the one that it is.</summary>
        public double this[int at] => numbers[at];

        /// <summary>All of it: long, double, string, MessageArray, List&lt;object&gt;,
        /// Dictionary&lt;string, object&gt;, GraphInstance; of one of several spaces a list, which one and what. It is
        /// made when it is asked for.</summary>
        public object Value => value ??= Decoded(row);

        /// <summary>Takes what Python has sent.</summary>
        /// <exception cref="MessageException">It is not in the space.</exception>
        public void Read(ReadOnlyMemory<byte> received)
        {
            row = received;
            value = null;
            if (space.Size < 0)
            {
                // Whether it is in the space shows when it is read.
                value = Decoded(row);
                return;
            }
            if (row.Length != space.Size) throw NotInSpace($"{row.Length} bytes are");
            var inside = true;
            var bytes = row.Span;
            for (int i = 0, at = 0, from = 0; i < parts.Length; i++)
            {
                inside &= parts[i].Read(bytes.Slice(from, parts[i].Size), numbers, at);
                at += parts[i].Count;
                from += parts[i].Size;
            }
            if (!inside) throw NotInSpace($"{GymSpace.Shown(numbers)} is");
        }

        /// <summary>Takes what somebody wants who plays by hand: numbers (double[]), any value of the space, or null,
        /// which is zeros.</summary>
        /// <exception cref="MessageException">They are not in the space.</exception>
        public void Set(object given)
        {
            var writer = new SpaceWriter(space);
            if ((given ?? new double[numbers.Length]) is double[] all) writer.Add(all);
            else writer.Set(given);
            Read(writer.End());
        }

        private object Decoded(ReadOnlyMemory<byte> bytes)
        {
            try
            {
                var decoded = Decode(space, ref bytes);
                if (bytes.Length > 0) throw NotInSpace($"{bytes.Length} bytes more than there are in it are");
                return decoded;
            }
            catch (Exception e) when (e is ArgumentException || e is OverflowException)
            {
                throw NotInSpace($"{row.Length} bytes are");
            }
        }

        private object Decode(GymSpace part, ref ReadOnlyMemory<byte> from)
        {
            switch (part.Kind)
            {
                case "text":
                    var text = MessageParts.ReadText(ref from);
                    return Fits(part, text) ? text : throw NotInSpace($"{MessageWriter.Shown(text)} is");
                case "dict":
                    var dict = new Dictionary<string, object>();
                    for (var i = 0; i < part.Parts.Length; i++) dict[part.Keys[i]] = Decode(part.Parts[i], ref from);
                    return dict;
                case "tuple":
                    var tuple = new List<object>();
                    foreach (var one in part.Parts) tuple.Add(Decode(one, ref from));
                    return tuple;
                case "sequence":
                    return Items(part.Parts[0], MessageParts.Size(ref from), ref from);
                case "one_of":
                    var which = MessageParts.Size(ref from);
                    if (which >= part.Parts.Length) throw NotInSpace($"{which} of {part.Parts.Length} is");
                    return new List<object> { (long)which, Decode(part.Parts[which], ref from) };
                case "graph": return Graph(part, ref from);
                default: return Number(part.Numbers, ref from);
            }
        }

        private static bool Fits(GymSpace part, string text)
        {
            var count = 0;
            for (int at = 0, size; at < text.Length; at += size, count++)
            {
                // One character of Python's may be two here.
                size = char.IsSurrogatePair(text, at) ? 2 : 1;
                if (part.Characters.IndexOf(text.Substring(at, size), StringComparison.Ordinal) < 0) return false;
            }
            return count >= part.Shortest && count <= part.Longest;
        }

        private object Number(SpaceNumbers part, ref ReadOnlyMemory<byte> from)
        {
            var bytes = MessageParts.Take(ref from, part.Size);
            var read = new double[part.Count];
            if (!part.Read(bytes.Span, read, 0)) throw NotInSpace($"{GymSpace.Shown(read)} is");
            if (part.IsSingle) return part.Dtype == "int64" ? (object)BitConverter.ToInt64(bytes.Span) : read[0];
            // The received array goes with its message; and a message has no int8.
            return part.Dtype == "int8"
                ? SpaceNumbers.Array("int32", read, part.Shape)
                : new MessageArray(part.Dtype, bytes.ToArray(), part.Shape);
        }

        private object Graph(GymSpace part, ref ReadOnlyMemory<byte> from)
        {
            var nodes = MessageParts.Size(ref from);
            var none = BitConverter.ToUInt32(from.Span) == uint.MaxValue;
            var edges = none ? 0 : BitConverter.ToInt32(from.Span);
            from = from.Slice(4);
            var allNodes = Items(part.Parts[0], nodes, ref from);
            if (none) return new GraphInstance(allNodes);
            if (part.Parts.Length < 2) throw NotInSpace("a graph with edges is");
            var allEdges = Items(part.Parts[1], edges, ref from);
            var links = new MessageArray("int32", MessageParts.Take(ref from, checked(8 * edges)).ToArray(), edges, 2);
            foreach (var node in SpaceNumbers.Of(links))
                if (node < 0 || node >= nodes) throw NotInSpace($"a graph with an edge of node {node}, of {nodes}, is");
            return new GraphInstance(allNodes, allEdges, links);
        }

        private List<object> Items(GymSpace part, int count, ref ReadOnlyMemory<byte> from)
        {
            // Each has a byte at least, or there are only few.
            if (count < 0 || count > from.Length + 1000) throw NotInSpace($"{count} items in {from.Length} bytes are");
            var items = new List<object>();
            for (var i = 0; i < count; i++) items.Add(Decode(part, ref from));
            return items;
        }

        private MessageException NotInSpace(string what) =>
            new MessageException("not-in-space", $"{what} not in {space}");
    }
}
