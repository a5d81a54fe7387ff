// The message standard of this kit: a JSON header, then one frame of raw bytes for each array.
//
//     frame 1     {"kind":"frame","version":1,"id":7,"values":{"bottom_up":true},
//                  "arrays":[{"dtype":"uint8","shape":[240,320,3]}]}           JSON, UTF-8, at most 64 KB
//     frame 2...  the arrays' items, row after row, little-endian; all arrays together at most 64 MB
//
// Values are texts, numbers, true and false by name. A reply has the request's id, and its kind is "ok", or "error"
// with the values "code", for programs, and "text", for people. Fields that this version does not know are ignored.
// It needs MessageReader.cs, MessageWriter.cs and MessageStore.cs, and neither NetMQ nor UnityEngine. The Python side
// is messages.py.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.IO;
using System.Runtime.InteropServices;

namespace NetMQExample
{
    /// <summary>What is wrong with a message: a code for programs, a text for people, and the message's id where it has
    /// one.</summary>
    public sealed class MessageException : IOException
    {
        /// <summary>With the code, such as <c>bad-shape</c>, first in its message.</summary>
        public MessageException(string code, string text, long id = 0) : base($"{code}: {text}")
        {
            Code = code;
            Id = id;
        }

        public string Code { get; }

        /// <summary>The message without the code.</summary>
        public string Text => Message.Substring(Code.Length + 2);

        /// <summary>The id of the request that the error answers; 0 where it has none.</summary>
        public long Id { get; }
    }

    /// <summary>An array of numbers: how they are to be read, and their bytes.</summary>
    public sealed partial class MessageArray
    {
        // The names are numpy's. All machines that Unity runs on are little-endian, as the bytes are.
        private static readonly Dictionary<string, (int Size, Type Type)> Kinds = new Dictionary<string, (int, Type)>
        {
            ["uint8"] = (1, typeof(byte)),
            ["uint16"] = (2, typeof(ushort)),
            ["int32"] = (4, typeof(int)),
            ["int64"] = (8, typeof(long)),
            ["float32"] = (4, typeof(float)),
            ["float64"] = (8, typeof(double)),
        };

        /// <summary>Describes bytes; they are not copied.</summary>
        /// <exception cref="MessageException">The bytes are not as many as dtype and shape say.</exception>
        public MessageArray(string dtype, ReadOnlyMemory<byte> data, params int[] shape)
        {
            Dtype = dtype ?? throw new ArgumentNullException(null, "dtype must not be null");
            Data = data;
            Shape = shape ?? throw new ArgumentNullException(null, "shape must not be null");
            // In double, which no product of eight sizes overflows.
            double size = SizeOf(dtype), items = 1;
            foreach (var length in shape)
            {
                size *= length;
                // Counted also where a 0 makes nothing of them: numpy takes no larger shape.
                items *= Math.Max(1, length);
                if (length < 0) items = double.PositiveInfinity;
            }
            if (shape.Length > 8 || items > Message.LimitBytes)
                throw new MessageException("bad-shape",
                    $"a shape is at most 8 whole numbers from 0, of at most {Message.LimitBytes} items");
            if (size != data.Length)
                throw new MessageException("bad-shape",
                    $"{dtype} [{string.Join(", ", shape)}] is not {data.Length} bytes");
        }

        internal static int SizeOf(string dtype) => Kinds.TryGetValue(dtype, out var kind)
            ? kind.Size
            : throw new MessageException("bad-dtype",
                $"dtype {MessageWriter.Shown(dtype)} is none of {string.Join(", ", Kinds.Keys)}");

        /// <summary>The kind of number: uint8, uint16, int32, int64, float32 or float64.</summary>
        public string Dtype { get; }

        /// <summary>How many there are in each dimension, such as height, width and 3.</summary>
        public int[] Shape { get; }

        /// <summary>Their bytes, row after row, little-endian.</summary>
        public ReadOnlyMemory<byte> Data { get; }

        /// <summary>The numbers, without a copy: <c>array.Items&lt;float&gt;()</c> for float32.</summary>
        /// <exception cref="MessageException">They are no T.</exception>
        public ReadOnlySpan<T> Items<T>() where T : struct => Kinds[Dtype].Type == typeof(T)
            ? MemoryMarshal.Cast<byte, T>(Data.Span)
            : throw new MessageException("bad-dtype", $"its numbers are {Dtype}, which is no {typeof(T).Name}");
    }

    /// <summary>One message. The frames that it was read from must not change while it is used.</summary>
    public sealed class Message
    {
        /// <summary>The version of this standard, the most bytes of a header, and of all arrays together.</summary>
        public const int Version = 1, HeaderLimitBytes = 64 * 1024, LimitBytes = 64 * 1024 * 1024;

        // Whole numbers nearer to zero than this are exact in every JSON reader, also in one that knows only doubles.
        private const long Exact = 1L << 53;
        // For what only the reading of a header needs.
        [ThreadStatic] private static MessageStore scratch;
        private readonly MessageStore store;

        /// <summary>A message without values and arrays, to which both can be added.</summary>
        public Message(string kind, long id = 0)
        {
            Kind = kind ?? throw new ArgumentNullException(null, "kind must not be null");
            Id = id;
        }

        /// <summary>One that is used again: what comes into it is valid until the next time, and each of its numbers is
        /// a MessageNumber.</summary>
        internal Message(MessageStore store) : this("") => this.store = store;

        /// <summary>What is asked for; of a reply, "ok" or "error".</summary>
        public string Kind { get; private set; }

        /// <summary>The number of the request, which its reply repeats.</summary>
        public long Id { get; private set; }

        /// <summary>Each is a string, bool, long or double; int and float may be written too.</summary>
        public Dictionary<string, object> Values { get; } = new Dictionary<string, object>();

        /// <summary>The arrays; their bytes are the frames after the header.</summary>
        public List<MessageArray> Arrays { get; } = new List<MessageArray>();

        /// <summary>The first frame; the arrays' bytes are the others.</summary>
        /// <exception cref="MessageException">A value has no place in a header, or it is too large.</exception>
        public string Header() => WriteHeader(new MessageWriter()).ToString();

        /// <summary>The same, in a buffer that is used again.</summary>
        internal MessageWriter WriteHeader(MessageWriter json)
        {
            CheckId();
            json.Begin().Add("{\"kind\":").Text(Kind).Add(",\"version\":").Whole(Version).Add(",\"id\":").Whole(Id);
            json.Add(",\"values\":{");
            foreach (var value in Values)
            {
                Check(value.Key, value.Value);
                json.Comma().Text(value.Key).Add(":").Value(value.Value);
            }
            json.Add("},\"arrays\":[");
            var size = 0L;
            foreach (var array in Arrays)
            {
                json.Comma().Add("{\"dtype\":").Text(array.Dtype).Add(",\"shape\":[");
                foreach (var length in array.Shape) json.Comma().Whole(length);
                json.Add("]}");
                size += array.Data.Length;
            }
            json.Add("]}");
            RefuseTooLarge(json.Written.Length, size);
            return json;
        }

        private void CheckId()
        {
            if (Id < 0 || Id >= Exact) throw new MessageException("bad-value", "'id' must be 0 to 2**53 - 1");
        }

        // Also before it is sent: a peer may hang up on it, without a word.
        private static void RefuseTooLarge(long header, long arrays)
        {
            if (header > HeaderLimitBytes || arrays > LimitBytes)
                throw new MessageException("too-big",
                    $"a header has at most {HeaderLimitBytes} bytes, all arrays together {LimitBytes}");
        }

        /// <summary>The message in the frames that were received, whose arrays are not copied.</summary>
        /// <exception cref="MessageException">They are no message; its text says why.</exception>
        public static Message Read(IReadOnlyList<ReadOnlyMemory<byte>> frames) => new Message("").ReadAgain(frames);

        internal Message ReadAgain(IReadOnlyList<ReadOnlyMemory<byte>> frames)
        {
            if (frames.Count == 0)
                throw new MessageException("bad-frames", "a message has at least one frame, its header");
            var size = 0L;
            for (var i = 1; i < frames.Count; i++) size += frames[i].Length;
            RefuseTooLarge(frames[0].Length, size);
            var parts = Begin("", 0) ?? (scratch ??= new MessageStore());
            parts.Clear();
            var fields = MessageReader.Read(frames[0].Span, parts);
            // The version comes first: another one may have other fields.
            if (TakeWhole(fields, "version") != Version)
                throw new MessageException("bad-version", $"not version {Version}: are both sides of one release?");
            Kind = Take<string>(fields, "kind", "text");
            Id = TakeWhole(fields, "id");
            var values = Take<Dictionary<string, object>>(fields, "values", "dict");
            CheckId();
            foreach (var value in values)
            {
                Check(value.Key, value.Value);
                Values[value.Key] = value.Value;
            }
            var arrays = Take<List<object>>(fields, "arrays", "list");
            if (arrays.Count != frames.Count - 1)
                throw new MessageException("bad-frames",
                    $"the header lists {arrays.Count} arrays, but {frames.Count - 1} frames follow it");
            foreach (var array in arrays) Arrays.Add(ReadArray(array, frames[Arrays.Count + 1]));
            return this;
        }

        /// <summary>Empties it.</summary>
        /// <returns>Where it has its numbers.</returns>
        internal MessageStore Begin(string kind, long id)
        {
            Kind = kind;
            Id = id;
            Values.Clear();
            Arrays.Clear();
            store?.Clear();
            return store;
        }

        /// <summary>This reply, unless it is an error, which is thrown.</summary>
        internal Message OrThrow()
        {
            if (Kind != "error") return this;
            var code = Values.GetValueOrDefault("code") ?? "not said";
            var text = Values.GetValueOrDefault("text") ?? "not said";
            throw new MessageException(LogText.Printable($"{code}"), LogText.Printable($"{text}"), Id);
        }

        private static MessageArray ReadArray(object array, ReadOnlyMemory<byte> data)
        {
            var dtype = Take<string>(array, "dtype", "text");
            var lengths = Take<List<object>>(array, "shape", "list");
            // One too many is enough to be refused.
            var shape = new int[Math.Min(lengths.Count, 9)];
            for (var i = 0; i < shape.Length; i++)
                shape[i] = Whole(lengths[i]) is long length && length >= 0 && length <= LimitBytes ? (int)length : -1;
            return new MessageArray(dtype, data, shape);
        }

        private static T Take<T>(object from, string name, string what) where T : class =>
            Take(from, name) as T ?? throw new MessageException("wrong-type", $"'{name}' must be a {what}");

        private static long TakeWhole(object from, string name) => Whole(Take(from, name))
            ?? throw new MessageException("wrong-type", $"'{name}' must be a whole number");

        private static object Take(object from, string name)
        {
            if (!(from is Dictionary<string, object> fields))
                throw new MessageException("wrong-type", $"expected an object with '{name}'");
            return fields.TryGetValue(name, out var value) ? value
                : throw new MessageException("missing-field", $"there is no '{name}'");
        }

        private static long? Whole(object value) => value is long whole ? whole
            : value is MessageNumber number && number.IsWhole ? (long)number.Real : (long?)null;

        private static void Check(string name, object value)
        {
            if (value is string || value is bool) return;
            var (number, isWhole) = value switch
            {
                long whole => (whole, true),
                int whole => (whole, true),
                double real => (real, false),
                float real => (real, false),
                MessageNumber again => (again.Real, again.IsWhole),
                _ => throw new MessageException("wrong-type",
                    $"value {MessageWriter.Shown(name)} must be text, a number, true or false"),
            };
            // NaN is not less than anything.
            if (!(Math.Abs(number) < (isWhole ? Exact : double.PositiveInfinity)))
                throw new MessageException("bad-value",
                    $"value {MessageWriter.Shown(name)} is not finite, or too large to be exact");
        }
    }
}
