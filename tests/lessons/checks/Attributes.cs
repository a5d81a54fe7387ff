// Classes with every kind of member that an attribute can stand at, and what is seen of them.
using System;
using System.Collections.Generic;
using System.Linq;
using UnityEngine;

#pragma warning disable CA1823, CS0414, IDE0051, IDE0052 // Only reflection reads these members.

namespace NetMQExample.Tests
{
    /// <summary>Counts how often reflection makes it: once for each class that has it.</summary>
    internal sealed class CountedAttribute : ObsAttribute
    {
        public CountedAttribute() => Made++;
        public static int Made { get; private set; }
    }

    internal enum Gear
    {
        Back = -1, None, First,
    }

    internal class Machine
    {
        [Obs] private readonly int hidden = 7;
        [Obs(".old")] private readonly float shadowed = 1;

        [Obs] public virtual string Says => "machine";

        [Counted] protected Gear Gear { get; set; } = Gear.Back;
    }

    internal sealed class Car : Machine
    {
        [Obs] private readonly bool yes = true;
        [Obs] private readonly double tenth = 0.1;
        [Obs(".single")] private readonly float third = 1 / 3f;
        [Obs] private readonly decimal money = 1.25m;
        [Obs] private readonly string text = "naïve \U0001f697";
        [Obs] private readonly object nothing = null;
        [Obs(".of.bytes")] private readonly byte[,] bytes = { { 1, 2, 3 }, { 4, 5, 6 } };
        [Obs] private readonly List<int> whole = new() { 1, -2 };
        [Obs] private readonly bool[] bits = { true, false };
        [Obs] private readonly short[] small = { -5 };
        [Obs] private readonly object[] mixed = { 1, "two", new[] { 3.5f } };
        [Obs] private readonly Dictionary<string, object> parts = new() { ["a"] = 1, ["b"] = new[] { 2L } };
        [Obs] private readonly GraphInstance graph = new(new MessageArray("float32", new byte[8], 2, 1));
        [Obs] private readonly Vector3 place = new(1, 2, 3);
        [Box("@@.turn")] private readonly Quaternion turn = new(0.5f, 0.25f, 0.125f, 1);
        [Box] private readonly Vector3[] way = { new(1, 2, 3), new(4, 5, 6) };
        [Box] private readonly List<float[]> rows = new() { new[] { 1f, 2 }, new[] { 3f, 4 } };
        [Box(".wheels(0)", "float64")] private readonly int wheel = 3;
        [Box] private readonly string letters = "aß";
        [Box("", "uint8")] private readonly double[] picture = { 0, 255 };
        [Box] private readonly Color32 colour = new(1, 2, 3, 4);
        [Box] private readonly Vector2Int cell = new(-1, 1);
        [Discrete] private readonly Gear gear = Gear.First;
        [Discrete] private readonly float round = 2;
        [Text] private readonly double spelled = 0.5;
        [Dict] private readonly Dictionary<string, Vector2> corners = new() { ["left"] = new Vector2(1, 2) };
        [List(".seen")] private readonly int[] seen = { 1, 2 };
        [List] private readonly Queue<string> queue = new(new[] { "x" });
        [Obs(".said[]")] private readonly string first = "one";
        [Obs(".said[] = $[0]")] private readonly string[] second = { "two" };
        [Obs] private readonly int hidden = 8;
        [Box("", "float")] private readonly int lone = 1;
        [Box(".twice", "<f8")] private readonly MessageArray doubled = new("float64", new byte[8]);
        [Box(".bit", "bool")] private readonly bool bit = true;
        [Box(".wide", "int16")] private readonly short wide = -1;
        [Graph]
        private readonly GraphInstance plain = new(new[,] { { 1f, 2 } }, new[] { new[] { 3.0 } },
            new[,] { { 0, 0 } });
        [Box(null, "float32")] private readonly int exact = 16777216;
        [Discrete] private readonly long most = long.MaxValue;
        private int unseen = 9;

        [field: Discrete] public int Behind { get; } = 4;

        public override string Says => "not this";

        [Graph]
        private GraphInstance Edges { get; } = new(new MessageArray("int64", new byte[16], 2),
            new MessageArray("int64", new byte[8], 1), new MessageArray("int32", new byte[8], 1, 2));
    }

    // Each with one thing wrong.
    internal sealed class WrongLocator
    {
        [Obs(".speed[")] private readonly int speed = 1;
    }

    internal sealed class Unreadable
    {
        [Obs] private int Speed { set => _ = value; }
    }

    internal sealed class OnePlace
    {
        [Obs] private readonly int a = 1;
        [Obs(".a")] private readonly int b = 1;
    }

    internal sealed class NoObjects
    {
        [Box] private static float speed = 1;
    }

    internal sealed class TwoAttributes
    {
        [Box, Discrete] private readonly int speed = 1;
    }

    internal sealed class Indexed
    {
        [Box] public float this[int at] => at;
    }

    // And members each of which has one thing wrong with it that is found when it is read.
    internal sealed class Wrong
    {
        [Obs] private readonly float nan = float.NaN;
        [Obs] private readonly Version version = new(1, 0);
        [Box] private readonly int[][] ragged = { new[] { 1 }, new int[0] };
        [Box("", "uint8")] private readonly int big = 300;
        [Discrete] private readonly double half = 0.5;
        [Box("", "float128")] private readonly double dtype = 0.5;
        [Dict] private readonly Dictionary<int, int> keys = new() { [1] = 1 };
        [Obs] private readonly List<object> endless = new();
        [Box] private readonly List<object> deep = new();
        [Discrete] private readonly ulong wide = ulong.MaxValue;
        [Box("", "float32")] private readonly double huge = 1e300;
        [Box("", "float32")] private readonly int lossy = 16777217;

        public Wrong()
        {
            endless.Add(endless);
            deep.Add(deep);
        }

        [Obs] private int Broken => throw new InvalidOperationException("no gearbox");
    }

    internal static class Attributes
    {
        private static void Refused(Action use)
        {
            try
            {
                use();
                Console.WriteLine("nothing is wrong");
            }
            catch (Exception e) when (e is ArgumentException || e is MessageException || e is InvalidOperationException)
            {
                Console.WriteLine($"{e.GetType().Name} {e.Message}");
            }
        }

        public static void Print()
        {
            Observed.Engine = UnityValues.Numbers;
            var car = new AgentState("it's", new Car());
            foreach (var source in car.Sources)
                Console.WriteLine($"{source.Locator} : {ObservationChecks.Shown(source.Read())}");
            foreach (var wrong in new object[] { new WrongLocator(), new Unreadable(), new OnePlace(), new NoObjects(),
                new TwoAttributes(), new Indexed() })
                Refused(() => _ = new AgentState("car", wrong));
            foreach (var source in new AgentState("car", new Wrong()).Sources)
                Refused(() => ObservationChecks.Shown(source.Read()));
            for (var step = 0; step < 100; step++)
                foreach (var source in new AgentState("other", new Car()).Sources) source.Read();
            try { new MessageArray("float64", new byte[16], 2).Items<float>(); }
            catch (MessageException e) { Console.WriteLine(e.Message); }
            var half = BoxOf.Value(0.5f);
            var (seven, yes) = (BoxOf.Value(new[] { 7.0 }), BoxOf.Value(1L));
            Console.WriteLine(FormattableString.Invariant(
                $"half: {Convert.ToSingle(half)} {Convert.ToInt32(seven)} {Convert.ToBoolean(yes)} {half}"));
            Console.WriteLine(
                $"{BoxOf.Value(Enumerable.Range(1, 9).ToArray())} {Convert.ToString(BoxOf.Value(new byte[0, 2]))}");
            try { Convert.ToSingle(BoxOf.Value(new float[2])); }
            catch (InvalidCastException e) { Console.WriteLine(e.Message); }
            try { new AgentState("car", new Car()).AddReward(double.NaN); }
            catch (MessageException e) { Console.WriteLine(e.Message); }
            Console.WriteLine($"made {CountedAttribute.Made} times");
            var before = GC.GetAllocatedBytesForCurrentThread();
            for (var step = 0; step < 100; step++)
                foreach (var source in car.Sources) source.Read();
            var bytes = (GC.GetAllocatedBytesForCurrentThread() - before) / 100;
            Console.WriteLine($"{bytes} bytes a step for {car.Sources.Count} members");
        }
    }
}
