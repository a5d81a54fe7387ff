// A scene in which everything that is asked of anybody is written down: tests/lessons/office.py, in C#.
//
//     dotnet checks.dll office "ann ann bob:2" "ann 3" --endpoint tcp://127.0.0.1:5559
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;

namespace NetMQExample.Tests
{
    internal sealed class Office : IWorld
    {
        public const double Dt = 0.5;

        public List<IAgent> Clerks { get; } = new();
        public Stack<Clerk> Away { get; } = new();
        public double Drawn { get; private set; }
        public Action<object> Note { get; private set; }

        public static void Run(string names, string atMost, string endpoint)
        {
            var office = new Office();
            foreach (var parts in names.Split(' ').Select(name => name.Split(':')))
                office.Clerks.Add(new Clerk(parts[0], office, parts.Length > 1 ? Program.Whole(parts[1]) : 1));
            var simulator = new SceneSimulator("Office", Dt, office.Clerks, office)
            {
                Warn = Console.WriteLine,
                Refuse = (clerk, why) => Console.WriteLine(why),
            };
            var words = atMost.Split(new[] { ' ' }, StringSplitOptions.RemoveEmptyEntries);
            for (var i = 0; i < words.Length; i += 2) simulator.AtMost[words[i]] = Program.Whole(words[i + 1]);
            simulator.OnInfo += simulator.SendInfo;
            office.Note = simulator.SendInfo;
            using var client = new EnvironmentClient(endpoint, TimeSpan.FromSeconds(20), Console.WriteLine);
            client.Run(simulator, 0, answer => answer());
        }

        public void OnReset(RandomGenerator random, IReadOnlyDictionary<string, object> options)
        {
            Note("office begins");
            Drawn = random.Next();
        }

        public void OnTick(double dt) => Note("office ticks");
        public void OnStepped() => Note("office stepped");
        public MessageArray Render() => null;
    }

    internal sealed class Clerk : PlainAgent
    {
        private static readonly GymSpace Words = GymSpace.Text(20, 0, "abcdefghijklmnopqrstuvwxyz0123456789 .");
        private static readonly GymSpace Seen = GymSpace.Dict(
            ("drawn", GymSpace.Box(
                RecordChecks.Array("float64", 0, 0), RecordChecks.Array("float64", 1, 1))),
            ("letters", GymSpace.Sequence(Words)), ("ticks", GymSpace.Box(0, 100, 1)));

        // The names under which a clerk may say something.
        private static readonly Dictionary<string, object> Values = new()
        {
            ["nothing"] = 0L,
            ["part"] = 0.75,
            ["false"] = false,
            ["text"] = "abc",
            ["none"] = RecordChecks.Array("float64"),
            ["one"] = RecordChecks.Array("float64", 1),
            ["two"] = RecordChecks.Array("int32", 1, 1),
            ["list"] = new List<object> { 1L, 2L },
            ["dict"] = new Dictionary<string, object> { ["a"] = 1L },
        };

        private readonly Office office;
        private readonly List<object> letters = new();
        private double drawn;
        private int ticks;
        private string plan;
        // The agent that it ends when it begins next.
        private Clerk foe;

        public Clerk(string name, Office office, int period = 1) : base(name, period) => this.office = office;
        public override GymSpace Observation => Seen;
        public override GymSpace Action => Words;

        public override void OnReset()
        {
            Note("begins");
            (drawn, ticks, plan) = (Rng.Next(), 0, "");
            letters.Clear();
            foe?.Terminate();
            foe = null;
        }

        public override void OnAction(object action)
        {
            plan = (string)action;
            Note($"does {plan}");
            var words = plan.Split(new[] { ' ' }, StringSplitOptions.RemoveEmptyEntries);
            if (plan == "end") Terminate();
            else if (plan == "recall") office.Clerks.Add(office.Away.Pop());
            switch (words.FirstOrDefault())
            {
                case "earn": AddReward(double.Parse(words[1], CultureInfo.InvariantCulture)); break;
                case "say":
                    for (var i = 1; i < words.Length; i++)
                        Info[FormattableString.Invariant($"value{i - 1}")] = Values[words[i]];
                    break;
                case "shout": Shout(); break;
                case "leave":
                    if (words.Length > 1)
                    {
                        letters.Add(words[1]);
                        Terminate();
                    }
                    office.Clerks.Remove(this);
                    office.Away.Push(this);
                    break;
                case "hire": office.Clerks.Add(new Clerk(words[1], office)); break;
                case "swap":
                    AddReward(1);
                    office.Clerks.Remove(this);
                    office.Clerks.Add(new Clerk(words[1], office));
                    break;
                case "doom":
                    foe = (Clerk)office.Clerks[Program.Whole(words[1])];
                    Terminate();
                    break;
                case "haunt":
                    office.Away.Peek().AddReward(1);
                    office.Away.Peek().Terminate();
                    break;
            }
        }

        public override void OnTick(double dt)
        {
            Note(dt == Office.Dt ? "ticks" : "ticks wrongly");
            ticks++;
            if (plan == "end soon") Terminate();
        }

        public override void OnStepped()
        {
            Note("stepped");
            AddReward(0.25);
            if (plan == "end late") Terminate();
            if (plan == "go late") office.Clerks.Remove(this);
        }

        public override void Observe(SpaceWriter seen)
        {
            Note("sees");
            if (plan == "end last") Terminate();
            seen.Set(new Dictionary<string, object>
            {
                ["drawn"] = new[] { drawn, office.Drawn },
                ["letters"] = letters,
                ["ticks"] = new[] { (float)ticks },
            });
        }

        public override void OnInfo(object info)
        {
            Note("hears");
            SendInfo(info);
        }

        private void Note(string what) => office.Note($"{Name} {what}");

        private void Shout()
        {
            var text = string.Concat(Enumerable.Repeat("é\"", 20));
            for (var i = 0L; i < 1000; i++)
                SendInfo(new Dictionary<string, object> { ["number"] = i, ["text"] = text });
        }
    }
}
