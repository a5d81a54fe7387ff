// Lesson 09, the spaces: what a simulation says of what it sees and takes, for Gymnasium. In Python: spaces.py.
//
// A hello names the kinds, "box" or "discrete", as the values "observation" and "action". Its arrays are the rest: of a
// box the lowest and the highest numbers, whose dtype and shape are those of the box; of a discrete one how many there
// are, an int64. An observation or an action is then one array. What is not in its space is refused.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using System.Runtime.InteropServices;

namespace NetMQExample
{
    /// <summary>A set of arrays: all those between two of them, or one whole number.</summary>
    public sealed class GymSpace
    {
        private readonly double[] low, high;

        private GymSpace(string kind, MessageArray form, params MessageArray[] arrays)
        {
            Kind = kind;
            Form = form;
            Arrays = arrays;
            low = kind == "box" ? Numbers(arrays[0]) : new[] { 0.0 };
            high = kind == "box" ? Numbers(arrays[1]) : new[] { Numbers(arrays[0])[0] - 1 };
        }

        /// <summary>What Python calls it.</summary>
        public string Kind { get; }

        /// <summary>Its numbers for a hello.</summary>
        public IReadOnlyList<MessageArray> Arrays { get; }

        private MessageArray Form { get; }

        /// <summary>The whole numbers from 0 on, so many of them.</summary>
        public static GymSpace Discrete(long count) =>
            new GymSpace("discrete", ToArray("int64", new double[1]), ToArray("int64", new double[] { count }));

        /// <summary>As many float32 as there are limits, each between two of them.</summary>
        public static GymSpace Box(double[] low, double[] high) =>
            Box(ToArray("float32", low, low.Length), ToArray("float32", high, high.Length));

        /// <summary>Arrays of the same dtype and shape as these two, and between them.</summary>
        public static GymSpace Box(MessageArray low, MessageArray high) => new GymSpace("box", low, low, high);

        /// <summary>Pictures: uint8 [height, width, 3], the highest row first.</summary>
        public static GymSpace Picture(int height, int width) => Box(
            new MessageArray("uint8", new byte[height * width * 3], height, width, 3),
            new MessageArray("uint8", Enumerable.Repeat((byte)255, height * width * 3).ToArray(), height, width, 3));

        /// <summary>The action of somebody who touches nothing: zeros.</summary>
        public double[] Nothing => new double[low.Length];

        /// <summary>Numbers as an array of this space; it is not checked whether they are in it.</summary>
        /// <exception cref="MessageException">It has not so many.</exception>
        public MessageArray Of(params double[] numbers) => numbers.Length == low.Length
            ? ToArray(Form.Dtype, numbers, Form.Shape)
            : throw new MessageException("not-in-space", $"{numbers.Length} numbers, and {this} has {low.Length}");

        /// <summary>The numbers of an array that somebody sent.</summary>
        /// <exception cref="MessageException">It is not in this space.</exception>
        public double[] Read(IReadOnlyList<MessageArray> arrays)
        {
            if (arrays.Count != 1)
                throw new MessageException("not-in-space", $"{arrays.Count} arrays are not one of {this}");
            var array = arrays[0];
            var numbers = Numbers(arrays[0]);
            var inside = array.Dtype == Form.Dtype && array.Shape.SequenceEqual(Form.Shape);
            // NaN is not between any two numbers.
            for (var i = 0; inside && i < numbers.Length; i++) inside = numbers[i] >= low[i] && numbers[i] <= high[i];
            if (inside) return numbers;
            throw new MessageException("not-in-space",
                $"{array.Dtype} {Shown(array.Shape)} {Shown(numbers)} is not in {this}");
        }

        /// <summary>As people read it.</summary>
        public override string ToString() => Kind == "discrete"
            ? FormattableString.Invariant($"Discrete({high[0] + 1})")
            : $"Box({Shown(low)}, {Shown(high)}, {Shown(Form.Shape)}, {Form.Dtype})";

        private static string Shown<T>(IReadOnlyCollection<T> items)
        {
            var few = items.Take(8).Select(item => Convert.ToString(item, CultureInfo.InvariantCulture));
            return $"[{string.Join(", ", few)}{(items.Count > 8 ? ", …" : "")}]";
        }

        /// <summary>The numbers of an array of any dtype.</summary>
        public static double[] Numbers(MessageArray array)
        {
            double[] All<T>() where T : struct, IConvertible =>
                Array.ConvertAll(array.Items<T>().ToArray(), item => item.ToDouble(CultureInfo.InvariantCulture));
            switch (array.Dtype)
            {
                case "uint8": return All<byte>();
                case "uint16": return All<ushort>();
                case "int32": return All<int>();
                case "int64": return All<long>();
                case "float32": return All<float>();
                default: return All<double>();
            }
        }

        private static MessageArray ToArray(string dtype, double[] numbers, params int[] shape)
        {
            MessageArray Make<T>(Converter<double, T> to) where T : struct => new MessageArray(
                dtype, MemoryMarshal.AsBytes<T>(Array.ConvertAll(numbers, to)).ToArray(), shape);
            switch (dtype)
            {
                case "uint8": return Make(number => (byte)number);
                case "uint16": return Make(number => (ushort)number);
                case "int32": return Make(number => (int)number);
                case "int64": return Make(number => (long)number);
                case "float32": return Make(number => (float)number);
                default: return Make(number => number);
            }
        }
    }
}
