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

        /// <summary>The same where it is the commonest: its numbers are written, and its form is returned; else null.
        /// </summary>
        internal virtual string Write(object value, FrameBuffer to) =>
            GetType() == typeof(ObsAttribute) ? Plain.Write(value, to) : null;
    }

    /// <summary>An array of numbers: of a number, of items in items, of a Vector3.</summary>
    public sealed class BoxAttribute : ObsAttribute
    {
        private readonly string dtype;

        /// <summary>Without a dtype, such as float32, it is that of the member.</summary>
        public BoxAttribute(string locator = "", string dtype = "") : base(locator) => this.dtype = dtype;

        /// <inheritdoc/>
        public override object Read(object value) => BoxOf.Value(value, dtype);

        internal override string Write(object value, FrameBuffer to) => Plain.WriteBox(value, dtype, to);
    }

    /// <summary>A whole number.</summary>
    public sealed class DiscreteAttribute : ObsAttribute
    {
        /// <inheritdoc/>
        public DiscreteAttribute(string locator = "") : base(locator) { }

        /// <inheritdoc/>
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
        /// <inheritdoc/>
        public TextAttribute(string locator = "") : base(locator) { }

        /// <inheritdoc/>
        public override object Read(object value) => FormattableString.Invariant($"{value}");

        internal override string Write(object value, FrameBuffer to) => value is string ? Plain.Write(value, to) : null;
    }

    /// <summary>A dictionary with keys of text.</summary>
    public sealed class DictAttribute : ObsAttribute
    {
        /// <inheritdoc/>
        public DictAttribute(string locator = "") : base(locator) { }

        /// <inheritdoc/>
        public override object Read(object value) => Observed.Dict(value);
    }

    /// <summary>Items for a Tuple or a Sequence, each of its own kind.</summary>
    public sealed class ListAttribute : ObsAttribute
    {
        /// <inheritdoc/>
        public ListAttribute(string locator = "") : base(locator) { }

        /// <inheritdoc/>
        public override object Read(object value) => Observed.List(value);
    }

    /// <summary>A GraphInstance.</summary>
    public sealed class GraphAttribute : ObsAttribute
    {
        /// <inheritdoc/>
        public GraphAttribute(string locator = "") : base(locator) { }

        /// <inheritdoc/>
        public override object Read(object value) => Observed.Of(value) as GraphInstance
            ?? throw new MessageException("no-space", $"{value?.GetType().Name ?? "null"} is no GraphInstance");
    }
}

namespace NetMQExample.Stripping
{
    /// <summary>By this name a code stripper knows what to leave.</summary>
    public abstract class PreserveAttribute : Attribute { }
}
