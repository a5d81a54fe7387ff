// Lesson 09, the numbers of a space: how they stand in a row, little-endian, and that none becomes another one there.
using System;
using System.Linq;

namespace NetMQExample
{
    /// <summary>Numbers of one dtype in a row: how they stand there, and between which two each of them lies.</summary>
    internal sealed class SpaceNumbers
    {
        // Up to here each whole number is one as a double, too.
        private const long MostExact = (1L << 53) - 1;

        // Compared once for each number: a text would take longer than all the rest.
        private enum Form { Int8, Uint8, Uint16, Int32, Int64, Float32, Float64 }

        private static readonly string[] Forms = { "int8", "uint8", "uint16", "int32", "int64", "float32", "float64" };

        private readonly double[] low, high;
        private readonly bool limited;
        private readonly Form form;

        public SpaceNumbers(string dtype, int[] shape, double[] low, double[] high)
        {
            if (dtype == "int64" && low.Concat(high).Any(one => Math.Abs(one) > MostExact))
                throw new ArgumentException("low and high of int64 lie between -2^53 and 2^53");
            Dtype = dtype;
            Shape = shape;
            this.low = low;
            this.high = high;
            form = FormOf(dtype);
            ItemSize = dtype == "int8" ? 1 : MessageArray.SizeOf(dtype);
            // All bytes of a picture are in the space.
            limited = dtype != "uint8" || low.Any(one => one > 0) || high.Any(one => one < 255);
        }

        public string Dtype { get; }
        public int[] Shape { get; }
        public int Count => low.Length;
        public int ItemSize { get; }
        public int Size => Count * ItemSize;
        public bool IsSingle => Shape.Length == 0;

        /// <summary>Reads a row into the numbers from a place on; false: it is not in the space.</summary>
        public bool Read(ReadOnlySpan<byte> row, double[] numbers, int at)
        {
            var inside = true;
            for (var i = 0; i < low.Length; i++)
            {
                var number = Get(form, row.Slice(i * ItemSize, ItemSize));
                numbers[at + i] = number;
                // NaN is not between any two numbers.
                inside &= !limited || (number >= low[i] && number <= high[i]);
            }
            return inside;
        }

        private static Form FormOf(string dtype) => (Form)System.Array.IndexOf(Forms, dtype);

        private static double Get(Form form, ReadOnlySpan<byte> bytes) => form switch
        {
            Form.Int8 => (sbyte)StepRequest.ByteOf(bytes),
            Form.Uint8 => StepRequest.ByteOf(bytes),
            Form.Uint16 => BitConverter.ToUInt16(bytes),
            Form.Int32 => BitConverter.ToInt32(bytes),
            Form.Int64 => BitConverter.ToInt64(bytes),
            Form.Float32 => BitConverter.ToSingle(bytes),
            _ => BitConverter.ToDouble(bytes),
        };

        /// <exception cref="MessageException">It would become another number, as 300 and 0.5 would in a byte.
        /// </exception>
        public void Put(Span<byte> bytes, double number) => Put(form, bytes, number);

        private static void Put(Form form, Span<byte> bytes, double number)
        {
            // NaN is neither whole nor between any two numbers.
            long Whole(long least, long most) => number >= least && number <= most && number == Math.Floor(number)
                ? (long)number : throw Another(form, number);
            switch (form)
            {
                case Form.Int8: bytes[0] = (byte)Whole(sbyte.MinValue, sbyte.MaxValue); break;
                case Form.Uint8: bytes[0] = (byte)Whole(0, byte.MaxValue); break;
                case Form.Uint16: BitConverter.TryWriteBytes(bytes, (ushort)Whole(0, ushort.MaxValue)); break;
                case Form.Int32: BitConverter.TryWriteBytes(bytes, (int)Whole(int.MinValue, int.MaxValue)); break;
                case Form.Int64: BitConverter.TryWriteBytes(bytes, Whole(-MostExact, MostExact)); break;
                case Form.Float32 when float.IsInfinity((float)number) && !double.IsInfinity(number):
                    throw Another(form, number);
                case Form.Float32: BitConverter.TryWriteBytes(bytes, (float)number); break;
                default: BitConverter.TryWriteBytes(bytes, number); break;
            }
        }

        private static MessageException Another(Form form, double number) => new MessageException("not-in-space",
            FormattableString.Invariant($"{number} would become another number as {Forms[(int)form]}"));

        /// <summary>The numbers of an array of any dtype.</summary>
        public static double[] Of(MessageArray array)
        {
            var (form, size) = (FormOf(array.Dtype), MessageArray.SizeOf(array.Dtype));
            var numbers = new double[array.Data.Length / size];
            for (var i = 0; i < numbers.Length; i++)
                numbers[i] = Get(form, array.Data.Span.Slice(i * size, size));
            return numbers;
        }

        public static MessageArray Array(string dtype, double[] numbers, params int[] shape)
        {
            var (form, size) = (FormOf(dtype), MessageArray.SizeOf(dtype));
            var data = new byte[numbers.Length * size];
            for (var i = 0; i < numbers.Length; i++) Put(form, data.AsSpan(i * size, size), numbers[i]);
            return new MessageArray(dtype, data, shape);
        }
    }
}
