// Lesson 11, boxes: numbers of C# as an array of a message.
//
// Arrays of numbers, with one dimension or more, are copied as they are. All else that has numbers in it goes one by
// one: lists, Vector3[], arrays in arrays. A dtype that a message lacks becomes the next larger one.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;

namespace NetMQExample
{
    /// <summary>Makes arrays.</summary>
    public static class BoxOf
    {
        // Of each dtype the types whose memory it is already, those that it is wide enough for, and its names in C#,
        // numpy and NumSharp.
        private static readonly (string Dtype, Type[] Same, Type[] Narrower, string Aliases)[] Table =
        {
            ("uint8", new[] { typeof(byte), typeof(bool) }, new Type[0], "bool ? b1 byte B u1"),
            ("uint16", new[] { typeof(ushort), typeof(char) }, new Type[0], "ushort char u2"),
            ("int32", new[] { typeof(int) }, new[] { typeof(sbyte), typeof(short) },
                "sbyte short int8 int16 int i1 i2 i4"),
            ("int64", new[] { typeof(long) }, new[] { typeof(uint), typeof(ulong) }, "uint uint32 u4 long i8"),
            ("float32", new[] { typeof(float) }, new Type[0], "float single f4"),
            ("float64", new[] { typeof(double) }, new[] { typeof(decimal) }, "double decimal f8"),
        };

        private static readonly Dictionary<Type, string> Same = Of(row => row.Same), Wider = Of(row => row.Narrower);
        private static readonly Dictionary<string, string> Aliases = Of(row => row.Aliases.Split(' '));
        private static readonly Dictionary<string, Type> Types =
            Table.ToDictionary(row => row.Dtype, row => row.Same[0]);

        /// <summary>Whether these items are nothing but numbers, by their type: float[], List&lt;int&gt;.</summary>
        public static bool IsNumbers(IEnumerable items)
        {
            var type = items.GetType();
            var item = type.IsArray ? type.GetElementType() : type.IsGenericType ? type.GetGenericArguments()[0] : null;
            return item != null && (Same.ContainsKey(item) || Wider.ContainsKey(item)) && item != typeof(char);
        }

        /// <summary>An array of whatever has numbers in it.</summary>
        /// <param name="value">A number, or items, or items in items, all equally many.</param>
        /// <param name="dtype">The dtype that it gets; if empty, that of its numbers.</param>
        /// <exception cref="MessageException">It is no array of numbers, or one would become another.</exception>
        public static MessageArray Value(object value, string dtype = "")
        {
            value = Observed.Engine(value);
            dtype = Named(dtype);
            if (value is MessageArray ready && (dtype == "" || dtype == ready.Dtype)) return ready;
            if (value is string text) value = text.ToCharArray();
            if (value is Array array && Same.TryGetValue(array.GetType().GetElementType(), out var own)
                && (dtype == "" || dtype == own))
                return Copy(own, array, Enumerable.Range(0, array.Rank).Select(array.GetLength).ToArray());
            var numbers = new List<object>();
            var shape = Flatten(value, numbers, 0);
            if (dtype == "") dtype = Natural(numbers.Count == 0 ? typeof(float) : numbers[0].GetType());
            var type = Types[dtype];
            var items = Array.CreateInstance(type, numbers.Count);
            for (var i = 0; i < items.Length; i++) items.SetValue(Exactly(numbers[i], type), i);
            return Copy(dtype, items, shape);
        }

        private static Dictionary<T, string> Of<T>(
            Func<(string Dtype, Type[] Same, Type[] Narrower, string Aliases), IEnumerable<T>> items) =>
            Table.SelectMany(items, (row, item) => (Item: item, row.Dtype))
                .ToDictionary(pair => pair.Item, pair => pair.Dtype);

        // In front may stand the order of bytes, as numpy has it: it changes no number.
        private static string Named(string dtype)
        {
            var name = (dtype ?? "").TrimStart('<', '>', '=', '|');
            if (Aliases.TryGetValue(name, out var own)) name = own;
            if (name == "" || Types.ContainsKey(name)) return name;
            throw new MessageException("bad-dtype", $"dtype {dtype} is none of {string.Join(", ", Types.Keys)}, "
                + "and none that becomes one of them, such as short or uint32");
        }

        private static string Natural(Type type) => type.IsEnum ? "int64"
            : Same.TryGetValue(type, out var dtype) || Wider.TryGetValue(type, out dtype) ? dtype
            : throw new MessageException("no-space", $"a Box has numbers, and no {type.Name}");

        private static MessageArray Copy(string dtype, Array items, int[] shape)
        {
            var data = new byte[Buffer.ByteLength(items)];
            Buffer.BlockCopy(items, 0, data, 0, data.Length);
            return new MessageArray(dtype, data, shape);
        }

        private static int[] Flatten(object value, List<object> numbers, int depth)
        {
            value = Observed.Engine(value);
            // Without a limit, a list that holds itself would end the program.
            if (depth > 8) throw new MessageException("bad-shape", "an array has at most 8 dimensions");
            if (value is Array array && array.Rank > 1)
            {
                foreach (var item in array) Flatten(item, numbers, depth + 1);
                return Enumerable.Range(0, array.Rank).Select(array.GetLength).ToArray();
            }
            if (!(value is IEnumerable items) || value is string)
            {
                var type = value?.GetType().Name ?? "null";
                if (!(value is IConvertible) || value is string || value is MessageArray)
                    throw new MessageException("no-space", $"a Box has numbers, and no {type}");
                numbers.Add(value is char unit ? (ushort)unit : value);
                return new int[0];
            }
            var shapes = items.Cast<object>().Select(item => Flatten(item, numbers, depth + 1)).ToList();
            if (shapes.Any(shape => !shape.SequenceEqual(shapes[0])))
                throw new MessageException("bad-shape", "its rows are not equally long");
            return shapes.Take(1).SelectMany(shape => shape).Prepend(shapes.Count).ToArray();
        }

        // A whole number stays what it is, or is refused: 300 is no uint8, and 1.5 neither. Of numbers with a fraction
        // it is only their precision that may change.
        private static object Exactly(object number, Type type)
        {
            var culture = CultureInfo.InvariantCulture;
            var code = Convert.GetTypeCode(number);
            try
            {
                var cast = Convert.ChangeType(number, type, culture);
                var fractions = code >= TypeCode.Single && (type == typeof(float) || type == typeof(double));
                if (fractions
                    ? !double.IsInfinity(Convert.ToDouble(cast)) || double.IsInfinity(Convert.ToDouble(number))
                    : Convert.ChangeType(cast, code, culture).Equals(Convert.ChangeType(number, code, culture)))
                    return cast;
            }
            catch (Exception e) when (e is OverflowException || e is InvalidCastException || e is FormatException) { }
            throw new MessageException("bad-value", FormattableString.Invariant(
                $"{number} would become another number as {Same[type]}"));
        }
    }
}
