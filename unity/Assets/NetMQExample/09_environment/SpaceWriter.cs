// Lesson 09, an observation: its numbers, one after the other, or a value of any space.
//
//     seen.Add(place, speed, angle, turning);             a Box of four
//     seen.Add(view.Observe(pixels)).Add(speed);          a Dict of a picture and a number, in the order of its parts
//     seen.Set(new Dictionary<string, object> { ["says"] = "hello", ["left"] = 3 });          any space
using System;
using System.Collections;
using System.Collections.Generic;
using System.Linq;

namespace NetMQExample
{
    /// <summary>Takes what is seen. It is used again for the next observation, and then makes no garbage.</summary>
    public sealed class SpaceWriter
    {
        private readonly GymSpace space;
        private readonly SpaceNumbers[] parts;
        private FrameBuffer to = new FrameBuffer();
        // Which part comes next, how many of its numbers are there, and where the row began.
        private int part, filled, began;
        private bool whole;

        public SpaceWriter(GymSpace space)
        {
            this.space = Require.Given("space", space);
            parts = space.AllNumbers;
            Skip(0);
        }

        /// <summary>The next number.</summary>
        /// <exception cref="MessageException">The space has no more, or what it has are no numbers, or this one would
        /// become another: 0.5 and 300 do not fit a byte.</exception>
        public SpaceWriter Add(double number)
        {
            var next = Next();
            next.Put(to.GetSpan(next.ItemSize), number);
            to.Advance(next.ItemSize);
            if (++filled == next.Count) Skip();
            return this;
        }

        public SpaceWriter Add(double one, double two) => Add(one).Add(two);
        public SpaceWriter Add(double one, double two, double three) => Add(one).Add(two).Add(three);

        public SpaceWriter Add(double one, double two, double three, double four) =>
            Add(one, two).Add(three, four);

#if UNITY_5_3_OR_NEWER
        public SpaceWriter Add(UnityEngine.Vector2 value) => Add(value.x, value.y);
        public SpaceWriter Add(UnityEngine.Vector3 value) => Add(value.x, value.y, value.z);
        public SpaceWriter Add(UnityEngine.Quaternion value) => Add(value.x, value.y, value.z, value.w);

#endif
        public SpaceWriter Add(params double[] numbers)
        {
            foreach (var number in numbers) Add(number);
            return this;
        }

        /// <summary>The next part as an array, such as a picture.</summary>
        /// <exception cref="MessageException">It is of another dtype or shape.</exception>
        public SpaceWriter Add(MessageArray array)
        {
            var next = Next();
            if (filled > 0 || array.Dtype != next.Dtype || !Same(array.Shape, next.Shape))
                throw NotInSpace($"{array.Dtype} {GymSpace.Shown(array.Shape)}");
            to.Write(array.Data.Span);
            Skip();
            return this;
        }

        /// <summary>The whole, in the types of C#: numbers, bool, string, arrays, MessageArray, dictionaries, lists,
        /// GraphInstance; for one of several spaces a list, which one and what.</summary>
        /// <exception cref="MessageException">It is not in the space.</exception>
        public void Set(object value)
        {
            if (whole || to.Count > began) throw NotInSpace("more than one value");
            Write(space, value);
            whole = true;
        }

        internal SpaceWriter Begin(FrameBuffer rows)
        {
            to = rows;
            began = rows.Count;
            part = 0;
            whole = false;
            Skip(0);
            return this;
        }

        /// <summary>Ends the row.</summary>
        /// <exception cref="MessageException">It is not whole.</exception>
        internal ReadOnlyMemory<byte> End()
        {
            if (whole || (space.Size >= 0 && part == parts.Length)) return to.From(began);
            throw NotInSpace(space.Size < 0 ? "what was not given to Set"
                : $"{parts.Take(part).Sum(one => one.Count) + filled} numbers of {space.Count}");
        }

        private SpaceNumbers Next() => !whole && part < parts.Length
            ? parts[part]
            : throw NotInSpace(space.Size < 0 ? "a number" : $"more than {space.Count} numbers");

        // The part is full. One without numbers is full at once.
        private void Skip(int by = 1)
        {
            filled = 0;
            for (part += by; part < parts.Length && parts[part].Count == 0;) part++;
        }

        private static bool Same(int[] one, int[] other) => one.AsSpan().SequenceEqual(other);

        private void Write(GymSpace of, object value)
        {
            switch (of.Kind)
            {
                case "text":
                    MessageParts.WriteText(to, value as string ?? throw Wrong(of, value));
                    return;
                case "dict":
                    var dict = value as IReadOnlyDictionary<string, object> ?? throw Wrong(of, value);
                    var extra = dict.Count > of.Parts.Length ? dict.Keys.First(key => !of.Keys.Contains(key)) : null;
                    if (extra != null) throw NotInSpace($"a dictionary with '{extra}'");
                    for (var i = 0; i < of.Parts.Length; i++)
                        Write(of.Parts[i], dict.TryGetValue(of.Keys[i], out var part)
                            ? part : throw NotInSpace($"a dictionary without '{of.Keys[i]}'"));
                    return;
                case "tuple":
                    var items = Items(of, value);
                    if (items.Count != of.Parts.Length) throw Wrong(of, value);
                    for (var i = 0; i < items.Count; i++) Write(of.Parts[i], items[i]);
                    return;
                case "sequence":
                    var several = Items(of, value);
                    to.Write((uint)several.Count);
                    foreach (var item in several) Write(of.Parts[0], item);
                    return;
                case "one_of":
                    var pair = Items(of, value);
                    var which = Enumerable.Range(0, of.Parts.Length)
                        .Where(at => pair.Count == 2 && Flat(pair[0]).SequenceEqual(new double[] { at })).ToArray();
                    if (which.Length == 0) throw Wrong(of, value);
                    to.Write((uint)which[0]);
                    Write(of.Parts[which[0]], pair[1]);
                    return;
                case "graph":
                    WriteGraph(of, value as GraphInstance ?? throw Wrong(of, value));
                    return;
                default:
                    WriteNumbers(of, value);
                    return;
            }
        }

        private void WriteGraph(GymSpace of, GraphInstance graph)
        {
            var nodes = Items(of, graph.Nodes);
            var edges = graph.Edges == null || of.Parts.Length < 2 ? null : Items(of, graph.Edges);
            to.Write((uint)nodes.Count);
            to.Write(edges == null ? uint.MaxValue : (uint)edges.Count);
            foreach (var node in nodes) Write(of.Parts[0], node);
            if (edges == null) return;
            foreach (var edge in edges) Write(of.Parts[1], edge);
            var links = Flat(graph.EdgeLinks).ToArray();
            if (links.Length != 2 * edges.Count) throw Wrong(of, graph.EdgeLinks);
            to.Write(SpaceNumbers.Array("int32", links, links.Length).Data.Span);
        }

        private void WriteNumbers(GymSpace of, object value)
        {
            var form = of.Numbers;
            if (value is MessageArray array && array.Dtype == form.Dtype && Same(array.Shape, form.Shape))
            {
                to.Write(array.Data.Span);
                return;
            }
            var count = 0;
            foreach (var number in Flat(value))
            {
                if (count++ == form.Count) throw Wrong(of, value);
                form.Put(to.GetSpan(form.ItemSize), number);
                to.Advance(form.ItemSize);
            }
            if (count != form.Count) throw Wrong(of, value);
        }

        // A number, or numbers in whatever holds them.
        private IEnumerable<double> Flat(object value)
        {
            if (value is MessageArray array) return SpaceNumbers.Of(array);
            if (value is bool yes) return new[] { yes ? 1.0 : 0.0 };
            if (value is IConvertible && !(value is string)) return new[] { Convert.ToDouble(value) };
            if (value is IEnumerable items && !(value is string)) return items.Cast<object>().SelectMany(Flat);
            throw NotInSpace(value?.GetType().Name ?? "null");
        }

        private IReadOnlyList<object> Items(GymSpace of, object value)
        {
            if (value is IReadOnlyList<object> list) return list;
            // One item for each number of the first dimension.
            if (value is MessageArray array && array.Shape.Length > 0)
            {
                var shape = array.Shape.Skip(1).ToArray();
                var size = array.Shape[0] == 0 ? 0 : array.Data.Length / array.Shape[0];
                return Enumerable.Range(0, array.Shape[0]).Select(i =>
                    (object)new MessageArray(array.Dtype, array.Data.Slice(i * size, size), shape)).ToList();
            }
            return value is IEnumerable items && !(value is string) ? items.Cast<object>().ToList()
                : throw Wrong(of, value);
        }

        private MessageException Wrong(GymSpace of, object value) =>
            new MessageException("not-in-space", $"{value?.GetType().Name ?? "null"} is not in {of}");

        private MessageException NotInSpace(string what) =>
            new MessageException("not-in-space", $"{what} is not in {space}");
    }
}
