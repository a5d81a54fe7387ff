// Lesson 11, the values that most members have, written as they are: no object is made of them.
using System;
using System.Runtime.InteropServices;

namespace NetMQExample
{
    /// <summary>Each writes the numbers and returns the form, as MessageTree.cs has it; or null, and writes nothing.
    /// </summary>
    internal static class Plain
    {
        private static readonly string[] Singles = Rows("float32"), Doubles = Rows("float64"), Ints = Rows("int32");

        /// <summary>A value of [Obs].</summary>
        public static string Write(object value, FrameBuffer to)
        {
            value = Observed.Engine(value);
            return value is float[] || value is double[] || value is int[] ? WriteBox(value, "", to)
                : value is Enum ? WriteWhole(value, to)
                // An array of numbers here, and not bytes.
                : value is byte[] ? null : MessageTree.AddSimple(to, value);
        }

        /// <summary>A value of [Discrete].</summary>
        public static string WriteWhole(object value, FrameBuffer to)
        {
            switch (value)
            {
                case int number: to.Write((long)number); break;
                case long number: to.Write(number); break;
                case bool yes: to.Write(yes ? 1L : 0L); break;
                case Enum one: to.Write(Convert.ToInt64(one)); break;
                default: return null;
            }
            return "\"int64\"";
        }

        /// <summary>A value of [Box].</summary>
        public static string WriteBox(object value, string dtype, FrameBuffer to)
        {
            switch (Observed.Engine(value))
            {
                case float number when dtype == "" || dtype == "float32":
                    to.Write((uint)BitConverter.SingleToInt32Bits(number));
                    return "\"float32[]\"";
                case double number when dtype == "" || dtype == "float64":
                    to.Write(number);
                    return "\"float64[]\"";
                case int number when dtype == "" || dtype == "int32":
                    to.Write((uint)number);
                    return "\"int32[]\"";
                case float[] numbers when dtype == "" || dtype == "float32":
                    return Row(MemoryMarshal.AsBytes<float>(numbers), Singles, numbers.Length, to);
                case double[] numbers when dtype == "" || dtype == "float64":
                    return Row(MemoryMarshal.AsBytes<double>(numbers), Doubles, numbers.Length, to);
                case int[] numbers when dtype == "" || dtype == "int32":
                    return Row(MemoryMarshal.AsBytes<int>(numbers), Ints, numbers.Length, to);
                default: return null;
            }
        }

        private static string Row(ReadOnlySpan<byte> numbers, string[] forms, int count, FrameBuffer to)
        {
            if (count >= forms.Length) return null;
            to.Write(numbers);
            return forms[count];
        }

        private static string[] Rows(string dtype)
        {
            var forms = new string[256];
            for (var count = 0; count < forms.Length; count++) forms[count] = $"\"{dtype}[{count}]\"";
            return forms;
        }
    }
}
