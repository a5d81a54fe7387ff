// Lesson 11, attributes: what an agent sees is said where it is declared.
//
//     [Box] private Vector3 velocity;                     float32 [3] under the key velocity
//     [Box(".wheels(0)", "float64")] private float left;  a number into an array; the locator says where
//     [Discrete] private int Gear => gearbox.Gear;        fields and properties, public or private, base classes' too
//     [Obs("@@.weather")] private string weather;         its own kind, and into the observation of every agent
//
// A managed code stripper takes away what nobody mentions, and reflection mentions nothing. Unity's spares whatever has
// an attribute of the name PreserveAttribute, whosever it is: from such a one these derive, so that neither this file
// nor your class needs UnityEngine. (Where stripping is set to High, put Unity's own [Preserve] on the class as well.)
// The Python side is netmq_example/envs/merge.py.
using System;
using System.Runtime.InteropServices;

namespace NetMQExample
{
    /// <summary>Its own value says how it is sent: whole numbers and enums as a number of Discrete, text as Text,
    /// arrays of numbers as Box, dictionaries as Dict, anything else that has items as a list.</summary>
    [AttributeUsage(AttributeTargets.Field | AttributeTargets.Property)]
    public class ObsAttribute : Stripping.PreserveAttribute
    {
        /// <summary>Without a locator the member's name is the key.</summary>
        public ObsAttribute(string locator = "") => Locator = locator ?? "";

        /// <summary>Where it goes; docs/guide/11_locators.md.</summary>
        public string Locator { get; }

        /// <summary>The member's value as a message can have it.</summary>
        public virtual object Read(object value) => Observed.Of(value);

        // Of the commonest values it writes the numbers, and returns the form; of all others null.
        internal virtual string Write(object value, FrameBuffer to) =>
            GetType() == typeof(ObsAttribute) ? Plain.Write(value, to) : null;
    }

    /// <summary>An array of numbers: of a number, of items in items, of a Vector3.</summary>
    public sealed class BoxAttribute : ObsAttribute
    {
        private readonly string dtype;

        /// <summary>Without a dtype, such as float32, it is that of the member.</summary>
        public BoxAttribute(string locator = "", string dtype = "") : base(locator) => this.dtype = dtype;

        public override object Read(object value) => BoxOf.Value(value, dtype);
        internal override string Write(object value, FrameBuffer to) => Plain.WriteBox(value, dtype, to);
    }

    /// <summary>A whole number.</summary>
    public sealed class DiscreteAttribute : ObsAttribute
    {
        public DiscreteAttribute(string locator = "") : base(locator) { }

        public override object Read(object value) => Observed.Of(value) switch
        {
            long whole => whole,
            bool yes => yes ? 1L : 0L,
            double number when Math.Floor(number) == number && Math.Abs(number) < 1L << 53 => (long)number,
            _ => throw new MessageException(
                "no-space", FormattableString.Invariant($"{value ?? "null"} is no whole number")),
        };

        internal override string Write(object value, FrameBuffer to) => Plain.WriteWhole(value, to);
    }

    /// <summary>Text: whatever it is, as people read it.</summary>
    public sealed class TextAttribute : ObsAttribute
    {
        public TextAttribute(string locator = "") : base(locator) { }

        public override object Read(object value) => FormattableString.Invariant($"{value}");
        internal override string Write(object value, FrameBuffer to) => value is string ? Plain.Write(value, to) : null;
    }

    /// <summary>A dictionary with keys of text.</summary>
    public sealed class DictAttribute : ObsAttribute
    {
        public DictAttribute(string locator = "") : base(locator) { }

        public override object Read(object value) => Observed.Dict(value);
    }

    /// <summary>Items for a Tuple or a Sequence, each of its own kind.</summary>
    public sealed class ListAttribute : ObsAttribute
    {
        public ListAttribute(string locator = "") : base(locator) { }

        public override object Read(object value) => Observed.List(value);
    }

    /// <summary>A GraphInstance.</summary>
    public sealed class GraphAttribute : ObsAttribute
    {
        public GraphAttribute(string locator = "") : base(locator) { }

        public override object Read(object value) => Observed.Of(value) as GraphInstance
            ?? throw new MessageException("no-space", $"{value?.GetType().Name ?? "null"} is no GraphInstance");
    }

    /// <summary>The values that most members have: each method writes the numbers, without an object, and returns the
    /// form, as MessageTree.cs has it; or null, and writes nothing.</summary>
    internal static class Plain
    {
        private static readonly string[] Singles = Rows("float32"), Doubles = Rows("float64"), Ints = Rows("int32");

        public static string Write(object value, FrameBuffer to)
        {
            value = Observed.Engine(value);
            if (value is Enum) return WriteWhole(value, to);
            if (value is float[] || value is double[] || value is int[]) return WriteBox(value, "", to);
            // An array of numbers here, and no bytes.
            if (value is byte[]) return null;
            return MessageTree.AddSimple(to, value);
        }

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

namespace NetMQExample.Stripping
{
    /// <summary>By this name a code stripper knows what to leave.</summary>
    public abstract class PreserveAttribute : Attribute { }
}
