// Lesson 09, the spaces: what a simulation says of what it sees and takes, for Gymnasium. In Python: spaces.py.
//
// A hello describes them; from then on what is in a space travels without a word: its arrays' numbers, little-endian,
// in the order of the space's parts.
//
//     description (a value, MessageTree.cs)             bytes
//     ["box", dtype, low, high]                         its numbers; low and high are arrays of its shape
//     ["discrete", n, start, "int64"]                   one number
//     ["multi_binary", shape]                           int8, 0 or 1, for each
//     ["multi_discrete", counts, starts, "int64"]       its numbers
//     ["text", shortest, longest, characters]           uint32, how many bytes; then UTF-8
//     ["dict", [[key, space], …]]  ["tuple", [space, …]]         one part after the other
//     ["sequence", space, stacked]                      uint32, how many; then one after the other
//     ["graph", nodes' space, edges' space or null]     uint32 nodes, uint32 edges, or 2^32 - 1 for none; the nodes,
//                                                       the edges, and int32 [edges, 2]
//     ["one_of", [space, …]]                            uint32, which one; then what is in it
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;

namespace NetMQExample
{
    /// <summary>A set of things that can be seen or done, as Gymnasium has them.</summary>
    public sealed class GymSpace
    {
        private const string Letters = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz";

        private readonly List<object> description;
        private readonly string text;
        // Counted once: each step asks.
        private int? size, count;

        private GymSpace(string kind, string text, params object[] description)
        {
            Kind = kind;
            this.text = text;
            this.description = description.Prepend(kind).ToList();
        }

        /// <summary>Its name in Python: box, discrete, dict and so on.</summary>
        public string Kind { get; }

        public IReadOnlyList<object> Description => description;

        /// <summary>How many bytes it always has; -1 where that varies.</summary>
        public int Size => size ??= Numbers?.Size ?? Sum(part => part.Size);

        /// <summary>How many numbers it has, of all parts together; -1 where that varies.</summary>
        public int Count => count ??= Numbers?.Count ?? Sum(part => part.Count);

        // Of a box, a discrete one and the like: how its numbers stand in a row.
        internal SpaceNumbers Numbers { get; private set; }

        // Of all parts, one after the other; none where the size varies.
        internal SpaceNumbers[] AllNumbers => Size < 0 ? new SpaceNumbers[0]
            : Numbers != null ? new[] { Numbers } : Parts.SelectMany(part => part.AllNumbers).ToArray();

        internal GymSpace[] Parts { get; private set; } = new GymSpace[0];

        internal string[] Keys { get; private set; } = new string[0];

        // Of a text.
        internal int Shortest { get; private set; }

        internal int Longest { get; private set; }

        internal string Characters { get; private set; } = "";

        /// <summary>The whole numbers from a start on, so many of them.</summary>
        public static GymSpace Discrete(long count, long start = 0) => new GymSpace(
            "discrete", FormattableString.Invariant(
                start == 0 ? (FormattableString)$"Discrete({count})" : $"Discrete({count}, start={start})"),
            count, start, "int64")
        {
            Numbers = new SpaceNumbers("int64", new int[0], new double[] { start }, new double[] { start + count - 1 }),
        };

        /// <summary>As many float32 as there are limits, each between two of them.</summary>
        public static GymSpace Box(double[] low, double[] high) => Box(
            SpaceNumbers.Array("float32", low, low.Length), SpaceNumbers.Array("float32", high, high.Length));

        /// <summary>float32 of a shape, all between the same two numbers.</summary>
        public static GymSpace Box(double low, double high, params int[] shape) => Box(
            SpaceNumbers.Array("float32", Filled(low, shape), shape),
            SpaceNumbers.Array("float32", Filled(high, shape), shape));

        /// <summary>Arrays of the same dtype and shape as these two, and between them.</summary>
        public static GymSpace Box(MessageArray low, MessageArray high)
        {
            var (least, most) = (SpaceNumbers.Of(low), SpaceNumbers.Of(high));
            if (low.Dtype != high.Dtype || !low.Shape.SequenceEqual(high.Shape))
                throw new ArgumentException("low and high of a box are arrays of one dtype and one shape");
            return new GymSpace("box", $"Box({Shown(least)}, {Shown(most)}, {Shown(low.Shape)}, {low.Dtype})",
                low.Dtype, low, high)
            { Numbers = new SpaceNumbers(low.Dtype, low.Shape, least, most) };
        }

        /// <summary>Pictures: uint8 [height, width, 3], the highest row first.</summary>
        public static GymSpace Picture(int height, int width) => Box(
            new MessageArray("uint8", new byte[height * width * 3], height, width, 3),
            new MessageArray("uint8", Enumerable.Repeat((byte)255, height * width * 3).ToArray(), height, width, 3));

        public static GymSpace MultiBinary(params int[] shape) => new GymSpace("multi_binary",
            $"MultiBinary({Shown(shape)})", shape.Select(length => (object)(long)length).ToList())
        { Numbers = new SpaceNumbers("int8", shape, Filled(0, shape), Filled(1, shape)) };

        /// <summary>Several whole numbers from 0 on, each with a count of its own.</summary>
        public static GymSpace MultiDiscrete(params long[] counts)
        {
            var all = Array.ConvertAll(counts, count => (double)count);
            return new GymSpace("multi_discrete", $"MultiDiscrete({Shown(counts)})",
                SpaceNumbers.Array("int64", all, all.Length),
                SpaceNumbers.Array("int64", new double[all.Length], all.Length), "int64")
            {
                Numbers = new SpaceNumbers("int64", new[] { all.Length }, new double[all.Length],
                    Array.ConvertAll(all, count => count - 1)),
            };
        }

        /// <summary>Texts of so many characters, all of which are among these.</summary>
        public static GymSpace Text(int longest, int shortest = 1, string characters = Letters) =>
            new GymSpace("text", FormattableString.Invariant($"Text({shortest}, {longest}, {characters})"),
                (long)shortest, (long)longest, Require.Given("characters", characters))
            { Shortest = shortest, Longest = longest, Characters = characters };

        public static GymSpace Dict(params (string Key, GymSpace Space)[] parts) => new GymSpace("dict",
            $"Dict({string.Join(", ", parts.Select(part => $"'{part.Key}': {part.Space}"))})",
            parts.Select(part => (object)new List<object> { part.Key, part.Space.description }).ToList())
        {
            Keys = Array.ConvertAll(parts, part => part.Key),
            Parts = Array.ConvertAll(parts, part => part.Space),
        };

        public static GymSpace Tuple(params GymSpace[] parts) => Of("tuple", "Tuple", parts);

        /// <summary>Any number of things of one space; stacked, they are one array with one dimension more.</summary>
        public static GymSpace Sequence(GymSpace space, bool stacked = false) =>
            new GymSpace("sequence", $"Sequence({space})", Require.Given("space", space).description, stacked)
            { Parts = new[] { space } };

        /// <summary>Nodes, and edges that connect them. Without a space of edges there are none.</summary>
        public static GymSpace Graph(GymSpace nodes, GymSpace edges = null) =>
            new GymSpace("graph", $"Graph({nodes}, {edges})", Require.Given("nodes", nodes).description,
                edges?.description)
            { Parts = edges == null ? new[] { nodes } : new[] { nodes, edges } };

        public static GymSpace OneOf(params GymSpace[] parts) => Of("one_of", "OneOf", parts);
        public override string ToString() => text;

        private int Sum(Func<GymSpace, int> of) =>
            Kind != "dict" && Kind != "tuple" || Parts.Any(part => part.Size < 0) ? -1 : Parts.Sum(of);

        private static GymSpace Of(string kind, string name, GymSpace[] parts) =>
            new GymSpace(kind, $"{name}({string.Join(", ", parts.Select(part => part.ToString()))})",
                parts.Select(part => (object)part.description).ToList())
            { Parts = parts };

        private static double[] Filled(double number, int[] shape) =>
            Enumerable.Repeat(number, shape.Aggregate(1, (product, length) => product * length)).ToArray();

        internal static string Shown<T>(IReadOnlyCollection<T> items)
        {
            var few = items.Take(8).Select(item => Convert.ToString(item, CultureInfo.InvariantCulture));
            return $"[{string.Join(", ", few)}{(items.Count > 8 ? ", …" : "")}]";
        }
    }
}
