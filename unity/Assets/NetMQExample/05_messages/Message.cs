// The message standard of this kit: a JSON header, then one frame of raw bytes for each array.
//
//     frame 1     {"kind":"frame","version":1,"id":7,"values":{"bottom_up":true},
//                  "arrays":[{"dtype":"uint8","shape":[240,320,3]}]}           JSON, UTF-8, at most 64 KB
//     frame 2...  the arrays' items, row after row, little-endian; all arrays together at most 64 MB
//
// Values are texts, numbers, true and false by name. A reply has the request's id, and its kind is "ok", or "error"
// with the values "code", for programs, and "text", for people. Fields that this version does not know are ignored.
// It needs Newtonsoft.Json, in Unity the package com.unity.nuget.newtonsoft-json, and neither NetMQ nor UnityEngine.
// The Python side is messages.py.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.IO;
using System.Linq;
using System.Runtime.InteropServices;
using System.Text;

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

        /// <summary>Such as <c>bad-shape</c>.</summary>
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
            if (shape.Aggregate((double)SizeOf(dtype), (product, length) => product * length) != data.Length)
                throw new MessageException("bad-shape",
                    $"{dtype} [{string.Join(", ", shape)}] is not {data.Length} bytes");
        }

        internal static int SizeOf(string dtype) => Kinds.TryGetValue(dtype, out var kind)
            ? kind.Size
            : throw new MessageException("bad-dtype",
                $"dtype {MessageJson.Shown(dtype)} is none of {string.Join(", ", Kinds.Keys)}");

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

        /// <summary>A message without values and arrays, to which both can be added.</summary>
        public Message(string kind, long id = 0)
        {
            Kind = kind ?? throw new ArgumentNullException(null, "kind must not be null");
            Id = id;
        }

        /// <summary>What is asked for; of a reply, "ok" or "error".</summary>
        public string Kind { get; }

        /// <summary>The number of the request, which its reply repeats.</summary>
        public long Id { get; }

        /// <summary>Each is a string, bool, long or double; int and float may be written too.</summary>
        public Dictionary<string, object> Values { get; } = new Dictionary<string, object>();

        /// <summary>The arrays; their bytes are the frames after the header.</summary>
        public List<MessageArray> Arrays { get; } = new List<MessageArray>();

        /// <summary>The first frame; the arrays' bytes are the others.</summary>
        /// <exception cref="MessageException">A value has no place in a header, or it is too large.</exception>
        public string Header()
        {
            foreach (var value in Values) Checked(value.Key, value.Value);
            var arrays = Arrays.Select(array =>
                new Dictionary<string, object> { ["dtype"] = array.Dtype, ["shape"] = array.Shape });
            var header = MessageJson.Write(new Dictionary<string, object>
            { ["kind"] = Kind, ["version"] = Version, ["id"] = Id, ["values"] = Values, ["arrays"] = arrays });
            RefuseTooLarge(Encoding.UTF8.GetByteCount(header), Arrays.Sum(array => (long)array.Data.Length));
            return header;
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
        public static Message Read(IReadOnlyList<ReadOnlyMemory<byte>> frames)
        {
            RefuseTooLarge(frames[0].Length, frames.Skip(1).Sum(frame => (long)frame.Length));
            var header = MessageJson.Read(frames[0].Span);
            // The version comes first: another one may have other fields.
            if (Take<long>(header, "version") != Version)
                throw new MessageException("bad-version", $"not version {Version}: are both sides of one release?");
            var message = new Message(Take<string>(header, "kind"), Take<long>(header, "id"));
            if (message.Id < 0 || message.Id >= Exact)
                throw new MessageException("bad-value", "'id' must be 0 to 2**53 - 1");
            foreach (var value in Take<Dictionary<string, object>>(header, "values"))
                message.Values[value.Key] = Checked(value.Key, value.Value);
            var arrays = Take<List<object>>(header, "arrays");
            if (arrays.Count != frames.Count - 1)
                throw new MessageException("bad-frames",
                    $"the header lists {arrays.Count} arrays, but {frames.Count - 1} frames follow it");
            message.Arrays.AddRange(arrays.Zip(frames.Skip(1), ReadArray));
            return message;
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
            var dtype = Take<string>(array, "dtype");
            var shape = Take<List<object>>(array, "shape");
            var whole = shape.All(length => length is long size && size >= 0 && size <= LimitBytes);
            // Its items are counted also where a 0 makes nothing of them: numpy takes no larger shape.
            if (shape.Count > 8 || !whole
                || shape.Aggregate(1.0, (all, one) => all * Math.Max(1, (long)one)) > LimitBytes)
                throw new MessageException("bad-shape",
                    $"a shape is at most 8 whole numbers, of at most {LimitBytes} items");
            return new MessageArray(dtype, data, shape.Select(length => (int)(long)length).ToArray());
        }

        private static T Take<T>(object where, string name)
        {
            if (!(where is Dictionary<string, object> fields))
                throw new MessageException("wrong-type", $"expected an object with '{name}'");
            if (!fields.TryGetValue(name, out var value))
                throw new MessageException("missing-field", $"there is no '{name}'");
            if (value is T right) return right;
            throw new MessageException("wrong-type", $"'{name}' must be {typeof(T).Name}");
        }

        internal static object Checked(string name, object value)
        {
            if (value is string || value is bool) return value;
            if (!(value is int || value is long || value is float || value is double))
                throw new MessageException("wrong-type",
                    $"value {MessageJson.Shown(name)} must be text, a number, true or false");
            var most = value is float || value is double ? double.PositiveInfinity : Exact;
            // NaN is not less than anything.
            if (Math.Abs(Convert.ToDouble(value, CultureInfo.InvariantCulture)) < most) return value;
            throw new MessageException("bad-value",
                $"value {MessageJson.Shown(name)} is not finite, or too large to be exact");
        }
    }
}
