// A scene without an engine, whose agents do what their action says, or what an info says: "terminate", "reward 1.5".
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

    internal sealed class World
    {
        public static readonly List<IAgent> Agents = new();
        public static readonly List<Source> Others = new();

        public static void Run(string endpoint, IEnumerable<string> names)
        {
            Agents.AddRange(names.DefaultIfEmpty("a b c").SelectMany(name => name.Split(' '))
                .Select(name => new Told(name)));
            var simulator = new SceneSimulator("World", 0.5, Agents, sensors: Others);
            simulator.OnInfo += info => simulator.SendInfo($"heard {info}");
            using var client = new EnvironmentClient(endpoint, TimeSpan.FromSeconds(20), Console.WriteLine);
            client.Run(simulator, 0, answer => answer());
        }
    }

    internal sealed class Told : PlainAgent
    {
        private static readonly char[] Blank = { ' ' };

        [Discrete] private int ticks;
        private int last;

        public Told(string name) : base(name, name == "b" ? 3 : 1)
        {
        }

        public override void OnReset()
        {
            (ticks, last) = (0, 0);
            World.Others.Clear();
            if (Options.Count == 0 && Name != "a") return;
            SendInfo(Rng.Next());
            SendInfo(Options);
        }

        public override void OnTick(double dt)
        {
            ticks += dt == 0.5 ? 1 : 100;
            if (last == 0 || ticks < last) return;
            AddReward(1);
            Terminate();
        }

        public override void OnInfo(object info)
        {
            if (info is string text && text.Contains(' ')) OnAction(text);
            else if (info is string word && (word == "terminate" || word == "truncate")) OnAction(word);
            else SendInfo(info);
        }

        public override void OnAction(object action)
        {
            var words = ((string)action).Split(Blank, StringSplitOptions.RemoveEmptyEntries);
            var rest = words.Skip(1).ToArray();
            // These were seen for one step alone.
            World.Others.Clear();
            switch (words.FirstOrDefault())
            {
                case "terminate": Terminate(); break;
                case "truncate": Truncate(); break;
                case "reward": AddReward(Number(rest[0])); break;
                case "all": SetReward(Number(rest[0])); break;
                case "info": SendInfo(rest[0]); break;
                case "draw":
                    SendInfo(World.Agents.First(one => one.AgentState.Name == rest[0]).AgentState.Rng.Next());
                    break;
                case "until": last = (int)Number(rest[0]); break;
                case "leave": World.Agents.Remove(this); break;
                case "come": World.Agents.Insert(1, new Told(rest[0])); break;
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

        private static double Number(string text) =>
            text == "nan" ? double.NaN : double.Parse(text, CultureInfo.InvariantCulture);

        private static void Wrong(object value) =>
            World.Others.AddRange(new AgentState("a", new Odd { Number = value }).Sources);

        private void See(string locator, Func<object> read) =>
            World.Others.Add(AgentState.Make("told", locator, "", AgentState.Scope, () => Observed.Of(Of(read()))));

        // NaN as an array: as a number it would not leave the house.
        private static object Of(object value) => value is float ? BoxOf.Value(value) : value;
    }
}
