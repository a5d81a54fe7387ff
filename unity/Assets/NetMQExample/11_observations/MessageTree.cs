// Lesson 11, trees: a value of any space as a message has it, one JSON text and the message's arrays.
//
//     5   0.5   true   null   "a text"   [1, 2]       long, double, bool, null, string, List<object>
//     {"array": 0}                                    MessageArray: the first one of the message
//     {"dict": {"speed": 5, "picture": {"array": 0}}}            Dictionary<string, object>
//     {"graph": {"nodes": …, "edges": …, "edge_links": …}}       MessageGraph; without edges both are null
//
// The Python side is netmq_example/spaces.py.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Text;

namespace NetMQExample
{
    /// <summary>Points, what lies between them, and which it connects: Gymnasium's GraphInstance. Each is an array, or
    /// null.</summary>
    public sealed class MessageGraph
    {
        /// <summary>Without edges, the other two are left out.</summary>
        public MessageGraph(object nodes, object edges = null, object edgeLinks = null)
        {
            Nodes = nodes;
            Edges = edges;
            EdgeLinks = edgeLinks;
        }

        /// <summary>An item for each node.</summary>
        public object Nodes { get; }

        /// <summary>An item for each edge.</summary>
        public object Edges { get; }

        /// <summary>For each edge the numbers of two nodes, counted from 0: int32 [edges, 2].</summary>
        public object EdgeLinks { get; }
    }

    /// <summary>Values to and from text.</summary>
    public static class MessageTree
    {
        private const double Exact = 1L << 53;

        /// <summary>The text of a value, whose arrays are added to those of its message.</summary>
        /// <exception cref="MessageException">It has no place in a message.</exception>
        public static string Write(object value, List<MessageArray> arrays) => MessageJson.Write(Node(value, arrays));

        /// <summary>The value that a text means.</summary>
        /// <exception cref="MessageException">It means none.</exception>
        public static object Read(string text, IReadOnlyList<MessageArray> arrays) =>
            Value(MessageJson.Read(Encoding.UTF8.GetBytes(text)), arrays);

        private static object Node(object value, List<MessageArray> arrays)
        {
            switch (value)
            {
                case null:
                case bool _:
                case string _: return value;
                case long _:
                case double _: return Checked(value);
                case MessageArray array:
                    arrays.Add(array);
                    return One("array", arrays.Count - 1);
                case MessageGraph graph:
                    return One("graph", new Dictionary<string, object>
                    {
                        ["nodes"] = Node(graph.Nodes, arrays),
                        ["edges"] = Node(graph.Edges, arrays),
                        ["edge_links"] = Node(graph.EdgeLinks, arrays),
                    });
                case Dictionary<string, object> parts:
                    return One("dict", parts.ToDictionary(part => part.Key, part => Node(part.Value, arrays)));
                case List<object> items: return items.ConvertAll(item => Node(item, arrays));
            }
            throw new MessageException("bad-tree", $"{value.GetType().Name} has no place in a message");
        }

        private static object Value(object node, IReadOnlyList<MessageArray> arrays)
        {
            if (node is List<object> items) return items.ConvertAll(item => Value(item, arrays));
            if (!(node is Dictionary<string, object> fields)) return Checked(node);
            var (name, inside) = fields.Count == 1 ? (fields.Keys.First(), fields.Values.First()) : ("", null);
            if (name == "array" && inside is long at && at >= 0 && at < arrays.Count) return arrays[(int)at];
            if (name == "dict" && inside is Dictionary<string, object> parts)
                return parts.ToDictionary(part => part.Key, part => Value(part.Value, arrays));
            if (name == "graph" && inside is Dictionary<string, object> graph && graph.Count == 3
                && graph.TryGetValue("nodes", out var nodes) && graph.TryGetValue("edges", out var edges)
                && graph.TryGetValue("edge_links", out var links))
                return new MessageGraph(Value(nodes, arrays), Value(edges, arrays), Value(links, arrays));
            throw new MessageException("bad-tree", $"a {{ }} is no array of {arrays.Count}, no dict, no graph");
        }

        internal static object Checked(object value)
        {
            if (!(value is long || value is double)) return value;
            // NaN is not less than anything.
            if (Math.Abs(Convert.ToDouble(value)) < (value is long ? Exact : double.PositiveInfinity)) return value;
            throw new MessageException("bad-value",
                FormattableString.Invariant($"{value} is not finite, or too large to be exact"));
        }

        private static Dictionary<string, object> One(string name, object value) =>
            new Dictionary<string, object> { [name] = value };
    }
}
