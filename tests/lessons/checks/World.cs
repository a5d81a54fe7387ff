// A scene without an engine, whose agents see by attributes, and do what their action says: "say one", "value 1".
// One whose name begins with sure has spaces in C#.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;

#pragma warning disable CA1823, CS0414, IDE0051, IDE0052 // Only reflection reads these members.

namespace NetMQExample.Tests
{
    /// <summary>What is wrong with it, it is told.</summary>
    internal sealed class Odd
    {
        [Obs("a@.value")] public object Number { get; set; }
    }

    internal static class World
    {
        public static readonly List<IAgent> Agents = new();
        public static readonly List<Source> Others = new();

        public static void Run(string endpoint, IEnumerable<string> names)
        {
            Agents.AddRange(names.Select(name => new Told(name)));
            using var client = new EnvironmentClient(endpoint, TimeSpan.FromSeconds(20), Console.WriteLine);
            client.Run(new SceneSimulator("World", 0.5, Agents, sensors: Others), 0, answer => answer());
        }
    }

    internal sealed class Told : PlainAgent
    {
        private static readonly GymSpace Words = GymSpace.Text(40, 0, "abcdefghijklmnopqrstuvwxyz0123456789. ");
        private readonly bool sure;
        [Discrete] private int ticks;

        public Told(string name) : base(name) => sure = name.StartsWith("sure", StringComparison.Ordinal);
        public override GymSpace Action => sure ? Words : null;

        public override GymSpace Observation => !sure ? null : GymSpace.Dict(
            ("said", GymSpace.Sequence(Words)),
            ("ticks", GymSpace.Discrete(1000)),
            ("value", GymSpace.Box(-9, 9, 2)));

        public override void OnReset()
        {
            ticks = 0;
            World.Others.RemoveAll(one => one.Names(Name));
        }

        public override void OnTick(double dt) => ticks++;

        // As if its own Update did it, between two steps.
        public override void OnInfo(object info) => OnAction(info);

        public override void OnAction(object action)
        {
            var words = ((string)action).Split(' ', StringSplitOptions.RemoveEmptyEntries);
            var rest = words.Skip(1).ToArray();
            // These were seen for one step alone.
            World.Others.RemoveAll(one => one.Names(Name));
            switch (words.FirstOrDefault())
            {
                case "terminate": Terminate(); break;
                case "truncate": Truncate(); break;
                case "reward": AddReward(Number(rest[0])); break;
                case "all": SetReward(Number(rest[0])); break;
                case "info": SendInfo(rest[0]); break;
                case "leave": World.Agents.Remove(this); break;
                case "say":
                    foreach (var word in rest) See(".said[]", () => word);
                    break;
                case "value": See(".value(1)", () => (float)Number(rest[0])); break;
                case "wide": See(".value", () => BoxOf.Value(new float[3])); break;
                case "text": See(".value", () => "text"); break;
                case "key": See(".nowhere", () => 1L); break;
                case "number": Wrong(double.NaN); break;
                case "type": Wrong(new Version()); break;
                case "throw": throw new InvalidOperationException("as it was told");
            }
        }

        // As bright as its number says.
        public override MessageArray Render() => Name.EndsWith("_0", StringComparison.Ordinal) ? null
            : new MessageArray("uint8", Enumerable.Repeat((byte)(10 + Name.Last() - '0'), 24).ToArray(), 2, 4, 3);

        private static double Number(string text) =>
            text == "nan" ? double.NaN : double.Parse(text, CultureInfo.InvariantCulture);

        private static void Wrong(object value) =>
            World.Others.AddRange(new AgentState("a", new Odd { Number = value }).Sources);

        private void See(string locator, Func<object> read) =>
            World.Others.Add(
                new Source("told", Locator.Parse(locator, "", AgentState.Scope), () => Observed.Of(Of(read()))));

        // NaN as an array: as a number it would not leave the house.
        private static object Of(object value) => value is float ? BoxOf.Value(value) : value;
    }
}
