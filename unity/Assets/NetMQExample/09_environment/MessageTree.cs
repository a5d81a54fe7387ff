// Lesson 09, values of any kind as bytes: their form as JSON, and then their numbers.
//
//     uint32, little-endian       how many bytes the form has
//     ...                         the form, JSON in ASCII
//     ...                         the numbers, little-endian, one after the other, as the form says
//
//     "null"  "bool"  "int64"  "float64"        null, bool, long, double: 0, 1, 8 and 8 bytes
//     "text"                                    string: uint32, how many bytes; then UTF-8
//     "bytes"                                   byte[]: uint32, how many bytes; then these
//     {"image": "bytes"}                        EncodedImage, a PNG or JPEG file
//     "float32[2,3]"                            MessageArray
//     [form, …]                                 List<object>
//     {"dict": {"speed": form, …}}              Dictionary<string, object>
//     {"graph": [nodes, edges, edge_links]}     GraphInstance; without edges both are "null"
//
// The form of most values stays the same from step to step, and so it is looked at once. The Python side is trees.py.
using System;
using System.Collections.Concurrent;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using System.Text;
using System.Text.RegularExpressions;

namespace NetMQExample
{
    /// <summary>Values to and from bytes.</summary>
    public static class MessageTree
    {
        private const int MostForms = 200, LongestForm = 16 * 1024, MostDepth = 100, MostFormBytes = 1 << 20;

        private static readonly Regex ArrayForm = new Regex(
            @"^([a-z]+[0-9]+)\[((?:[0-9]{1,9}(?:,[0-9]{1,9}){0,7})?)\]\z", RegexOptions.CultureInvariant);
        private static readonly ConcurrentDictionary<string, object> Forms = new();
        private static readonly ConcurrentDictionary<string, (string Dtype, int[] Shape)> Arrays = new();

        internal static void Write(FrameBuffer to, object value)
        {
            var form = new StringBuilder();
            var numbers = new FrameBuffer();
            Add(form, numbers, value);
            MessageParts.WriteText(to, form.ToString());
            to.Write(numbers.From(0).Span);
        }

        /// <summary>A value of the types above.</summary>
        /// <exception cref="MessageException">It has no place in a message.</exception>
        public static byte[] Write(object value)
        {
            var bytes = new FrameBuffer();
            Write(bytes, value);
            return bytes.From(0).ToArray();
        }

        /// <summary>The value that these bytes are.</summary>
        /// <exception cref="MessageException">They are none.</exception>
        public static object Read(ReadOnlyMemory<byte> data)
        {
            try
            {
                var size = checked((int)BitConverter.ToUInt32(data.Span.Slice(0, 4)));
                return Read(Form(data.Slice(4, size)), data.Slice(4 + size));
            }
            catch (Exception e) when (e is ArgumentException || e is OverflowException)
            {
                throw Bad(e.Message);
            }
        }

        /// <summary>The value of this form that these numbers are.</summary>
        internal static object Read(object form, ReadOnlyMemory<byte> numbers)
        {
            try
            {
                var value = Value(form, ref numbers);
                return numbers.Length == 0 ? value : throw Bad("more follows it");
            }
            catch (Exception e) when (e is ArgumentException || e is OverflowException
                || (e is MessageException m && m.Code == "bad-dtype"))
            {
                throw Bad(e.Message);
            }
        }

        /// <summary>A form, as JSON in ASCII. Most are known.</summary>
        internal static object Form(ReadOnlyMemory<byte> bytes)
        {
            if (bytes.Length > MostFormBytes)
                throw Bad($"its form has {bytes.Length} bytes, and {MostFormBytes} at most");
            var text = Encoding.ASCII.GetString(bytes.Span);
            if (Forms.TryGetValue(text, out var form)) return form;
            try { form = MessageReader.Read(bytes.Span, new MessageStore()); }
            catch (Exception e) when (e is ArgumentException || e is MessageException) { throw Bad(e.Message); }
            // A peer that sends ever new ones, or long ones, fills no memory.
            if (Forms.Count > MostForms) Forms.Clear();
            if (text.Length <= LongestForm) Forms[text] = form;
            return form;
        }

        /// <summary>Adds a value's form, and its numbers.</summary>
        internal static void Add(StringBuilder form, FrameBuffer numbers, object value, int depth = 0)
        {
            // Without a limit, a list that holds itself would end the program.
            if (depth > MostDepth) throw new MessageException("bad-tree", "it is nested too deeply, or has no end");
            if (AddSimple(numbers, value) is string known)
            {
                form.Append(known);
                return;
            }
            switch (value)
            {
                case MessageArray array:
                    form.Append($"\"{array.Dtype}[{string.Join(",", array.Shape)}]\"");
                    numbers.Write(array.Data.Span);
                    return;
                case GraphInstance graph:
                    form.Append("{\"graph\":");
                    AddAll(form, numbers, new[] { graph.Nodes, graph.Edges, graph.EdgeLinks }, depth);
                    form.Append('}');
                    return;
                case IReadOnlyDictionary<string, object> parts:
                    form.Append("{\"dict\":{");
                    var first = true;
                    foreach (var part in parts)
                    {
                        form.Append(first ? "" : ",").Append(MessageWriter.Quoted(part.Key)).Append(':');
                        Add(form, numbers, part.Value, depth + 1);
                        first = false;
                    }
                    form.Append("}}");
                    return;
                case IReadOnlyList<object> items:
                    AddAll(form, numbers, items, depth);
                    return;
            }
            throw new MessageException("bad-tree", $"{value.GetType().Name} has no place in a message");
        }

        /// <summary>Adds the numbers of a value whose type has but one form, which it returns; else null.</summary>
        internal static string AddSimple(FrameBuffer numbers, object value)
        {
            switch (value)
            {
                case null: return "\"null\"";
                case bool yes: numbers.Write((byte)(yes ? 1 : 0)); return "\"bool\"";
                case string text: MessageParts.WriteText(numbers, text); return "\"text\"";
                case byte[] bytes: MessageParts.WriteBytes(numbers, bytes); return "\"bytes\"";
                case EncodedImage image: MessageParts.WriteBytes(numbers, image.File); return "{\"image\":\"bytes\"}";
                case int number: numbers.Write((long)number); return "\"int64\"";
                case long number: numbers.Write(number); return "\"int64\"";
                case float number: numbers.Write(Finite(number)); return "\"float64\"";
                case double number: numbers.Write(Finite(number)); return "\"float64\"";
                default: return null;
            }
        }

        private static void AddAll(StringBuilder form, FrameBuffer numbers, IReadOnlyList<object> items, int depth)
        {
            form.Append('[');
            for (var i = 0; i < items.Count; i++)
            {
                if (i > 0) form.Append(',');
                Add(form, numbers, items[i], depth + 1);
            }
            form.Append(']');
        }

        private static object Value(object form, ref ReadOnlyMemory<byte> numbers)
        {
            switch (form)
            {
                case "null": return null;
                case "bool": return StepRequest.ByteOf(MessageParts.Take(ref numbers, 1).Span) != 0;
                case "int64": return BitConverter.ToInt64(MessageParts.Take(ref numbers, 8).Span);
                case "float64": return Finite(BitConverter.ToDouble(MessageParts.Take(ref numbers, 8).Span));
                case "text": return MessageParts.ReadText(ref numbers);
                case "bytes": return MessageParts.Take(ref numbers, MessageParts.Size(ref numbers)).ToArray();
                case string array: return ReadArray(array, ref numbers);
                case List<object> forms:
                    var items = new List<object>(forms.Count);
                    foreach (var one in forms) items.Add(Value(one, ref numbers));
                    return items;
                case Dictionary<string, object> fields when fields.Count == 1:
                    if (fields.TryGetValue("dict", out var inside) && inside is Dictionary<string, object> parts)
                    {
                        var dict = new Dictionary<string, object>();
                        foreach (var part in parts) dict[part.Key] = Value(part.Value, ref numbers);
                        return dict;
                    }
                    if (fields.TryGetValue("graph", out inside) && inside is List<object> three && three.Count == 3)
                        return new GraphInstance(
                            Value(three[0], ref numbers), Value(three[1], ref numbers), Value(three[2], ref numbers));
                    break;
            }
            throw Bad("a part of it has no form");
        }

        private static MessageArray ReadArray(string form, ref ReadOnlyMemory<byte> numbers)
        {
            var (dtype, shape) = Arrays.TryGetValue(form, out var known) ? known : Known(form);
            // In double, which no product of eight sizes overflows.
            double size = dtype == "int8" ? 1 : MessageArray.SizeOf(dtype);
            foreach (var length in shape) size *= length;
            if (size > numbers.Length) throw Bad("it ends too early");
            // A copy: what was received goes with its message. As in an action, int8 becomes int32.
            var data = MessageParts.Take(ref numbers, (int)size).ToArray();
            return dtype != "int8" ? new MessageArray(dtype, data, shape)
                : SpaceNumbers.Array("int32", Array.ConvertAll(data, number => (double)(sbyte)number), shape);
        }

        private static (string, int[]) Known(string form)
        {
            var parts = ArrayForm.Match(form);
            if (!parts.Success) throw Bad($"{MessageWriter.Shown(form)} is no form");
            var shape = parts.Groups[2].Value.Split(new[] { ',' }, StringSplitOptions.RemoveEmptyEntries)
                .Select(length => int.Parse(length, CultureInfo.InvariantCulture)).ToArray();
            if (Arrays.Count > MostForms) Arrays.Clear();
            return Arrays[form] = (parts.Groups[1].Value, shape);
        }

        // NaN is not less than anything.
        internal static double Finite(double number) => Math.Abs(number) < double.PositiveInfinity
            ? number : throw new MessageException("bad-value", FormattableString.Invariant($"{number} is not finite"));

        private static MessageException Bad(string why) =>
            new MessageException("bad-tree", $"this is no value: {why.Split('\n')[0]}");
    }

    /// <summary>Points, what lies between them, and which it connects. Each is an array, such as a float[,], or
    /// null.</summary>
    public sealed class GraphInstance
    {
        /// <summary>Without edges, the other two are left out.</summary>
        public GraphInstance(object nodes = null, object edges = null, object edgeLinks = null) =>
            (Nodes, Edges, EdgeLinks) = (nodes, edges, edgeLinks);

        public object Nodes { get; set; }
        public object Edges { get; set; }

        /// <summary>For each edge the numbers of two nodes, counted from 0: int32 [edges, 2].</summary>
        public object EdgeLinks { get; set; }

        public override string ToString() =>
            $"nodes {Nodes ?? "none"}; edges {Edges ?? "none"}; links {EdgeLinks ?? "none"}";
    }

    /// <summary>A PNG or JPEG file as a value: an observation, or an info.</summary>
    public sealed class EncodedImage
    {
        /// <summary>The file is not copied.</summary>
        public EncodedImage(byte[] file) => File = Require.Given("file", file);

        public byte[] File { get; }
    }
}
