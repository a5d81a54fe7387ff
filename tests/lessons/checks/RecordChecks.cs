// test_09_spaces.py asks this of the C# side:
//
//     rows                      each line of the input is a space's name, a number of agents and requests, in
//                               hexadecimal digits; it is answered with the answer to the last one, or "error" and the
//                               code
//     large                     why int64 beyond what a double knows exactly is no space
//     spaces                    what a hello says of CartPole's spaces, and of each space here
//     worlds ENDPOINT NAME …    simulates a world of each of these spaces, one after the other
//
// In such a world one sees what was done last; after a reset, what its option "say" says.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;

namespace NetMQExample.Tests
{
    internal static class RecordChecks
    {
        private static readonly GymSpace Pair = GymSpace.Box(new double[] { -1, -2 }, new double[] { 1, 2 });

        private static readonly Dictionary<string, GymSpace> Spaces = new Dictionary<string, GymSpace>
        {
            ["pair"] = Pair,
            ["grid"] = GymSpace.Box(-1, 1, 2, 3),
            ["number"] = GymSpace.Box(0, 1),
            ["nothing"] = GymSpace.Box(0, 1, 0),
            ["picture"] = GymSpace.Picture(4, 5),
            ["float64"] = GymSpace.Box(
                Array("float64", double.NegativeInfinity, 0), Array("float64", double.PositiveInfinity, 1)),
            ["uint8"] = GymSpace.Box(Array("uint8", 1, 2), Array("uint8", 3, 200)),
            ["uint16"] = GymSpace.Box(Array("uint16", 0, 7), Array("uint16", 65535, 7)),
            ["int32"] = GymSpace.Box(Array("int32", int.MinValue, -5), Array("int32", int.MaxValue, 5)),
            ["int64"] = GymSpace.Box(Array("int64", -5, 0), Array("int64", 5, 1L << 40)),
            ["discrete"] = GymSpace.Discrete(3),
            ["shifted"] = GymSpace.Discrete(4, -2),
            ["bits"] = GymSpace.MultiBinary(5),
            ["bits2"] = GymSpace.MultiBinary(2, 3),
            ["choices"] = GymSpace.MultiDiscrete(3, 4, 5),
            ["text"] = GymSpace.Text(8),
            ["letters"] = GymSpace.Text(5, 0, " xäö€😀"),
            ["dict"] = GymSpace.Dict(("a", GymSpace.Discrete(3)), ("b", Pair), ("c", GymSpace.MultiBinary(5))),
            ["tuple"] = GymSpace.Tuple(GymSpace.Text(8), GymSpace.Discrete(4, -2)),
            ["sequence"] = GymSpace.Sequence(Pair),
            ["words"] = GymSpace.Sequence(GymSpace.Text(8)),
            ["stack"] = GymSpace.Sequence(Pair, stacked: true),
            ["stacks"] = GymSpace.Sequence(GymSpace.Dict(("a", GymSpace.Discrete(3)), ("b", Pair)), stacked: true),
            ["nothings"] = GymSpace.Sequence(GymSpace.Box(0, 1, 0)),
            ["graph"] = GymSpace.Graph(Pair, GymSpace.Discrete(4, -2)),
            ["points"] = GymSpace.Graph(Pair),
            ["one"] = GymSpace.OneOf(GymSpace.Discrete(3), Pair, GymSpace.Text(8)),
            ["nested"] = GymSpace.Dict(
                ("a", GymSpace.Tuple(GymSpace.Sequence(GymSpace.Dict(("x", Pair), ("y", GymSpace.Text(8)))),
                    GymSpace.Discrete(3))),
                ("b", GymSpace.OneOf(GymSpace.Graph(Pair, GymSpace.Discrete(4, -2)),
                    GymSpace.Sequence(GymSpace.Sequence(Pair))))),
        };

        public static void Run(string[] words)
        {
            Program.WriteNumbersInGerman();
            if (words[0] == "rows") Program.EachLine(line => Answer(line.Split(' ')));
            else if (words[0] == "spaces") Describe();
            else if (words[0] == "large") Large();
            else foreach (var name in words.Skip(2)) Simulate(name, words[1]);
        }

        private static string Answer(string[] words)
        {
            var simulator = Of(words[0], int.Parse(words[1], CultureInfo.InvariantCulture));
            simulator.Hello();
            var request = new StepRequest();
            foreach (var digits in words.Skip(2))
            {
                try { request.Read(Hex.Bytes(digits)); }
                catch (MessageException e) { return $"error {e.Code}"; }
                simulator.Answer(request);
            }
            return simulator.Reply == null
                ? Hex.Digits(simulator.Frame.ToArray())
                : $"error {simulator.Reply.Values["code"]}";
        }

        private static SceneSimulator Of(string name, int count) => new SceneSimulator(
            name, 0.02, Enumerable.Range(0, count)
                .Select(_ => name == "fields" ? (IAgent)new Fields() : new Echo(Spaces[name])).ToArray());

        private static void Describe()
        {
            var hello = new SceneSimulator("CartPole", 0.02, new[] { new CartPole() }).Describe();
            Console.WriteLine($"hello {Hex.Digits(hello.Arrays.Single().Data.ToArray())}");
            foreach (var one in Spaces)
                Console.WriteLine($"{one.Key} {Hex.Digits(MessageTree.Write(one.Value.Description))}");
        }

        private static void Large()
        {
            try { GymSpace.Box(Array("int64", 0), Array("int64", 1L << 53)); }
            catch (ArgumentException e) { Console.WriteLine(e.Message); }
        }

        private static void Simulate(string name, string endpoint)
        {
            using var client = new EnvironmentClient(endpoint, TimeSpan.FromSeconds(60), Console.WriteLine);
            client.Run(Of(name, 1), 0, answer => answer());
        }

        public static MessageArray Array(string dtype, params double[] numbers)
        {
            var bytes = numbers.SelectMany(number => dtype switch
            {
                "uint8" => new[] { (byte)number },
                "uint16" => BitConverter.GetBytes((ushort)number),
                "int32" => BitConverter.GetBytes((int)number),
                "int64" => BitConverter.GetBytes((long)number),
                _ => BitConverter.GetBytes(number),
            });
            return new MessageArray(dtype, bytes.ToArray(), numbers.Length);
        }
    }

    internal sealed class Echo : PlainAgent
    {
        private object said;
        private double[] numbers;
        private int steps;

        public Echo(GymSpace space) : base("echo") => Observation = space;
        public override GymSpace Observation { get; }
        public override GymSpace Action => Observation;
        public override void OnReset() => (said, numbers, steps) = (Options["say"], null, 0);

        public override void OnAction(SpaceReader action)
        {
            // Every second time as numbers, where it is numbers.
            numbers = action.Count > 0 && steps % 2 == 1
                ? Enumerable.Range(0, action.Count).Select(at => action[at]).ToArray()
                : null;
            said = action.Value;
            steps++;
        }

        public override void OnStepped()
        {
            AddReward(0.5 * steps);
            if (steps == 3) Terminate();
            if (steps == 4) Truncate();
            Info["steps"] = steps;
        }

        public override void Observe(SpaceWriter seen)
        {
            if (numbers == null) seen.Set(said);
            else seen.Add(numbers);
        }
    }

    /// <summary>One by attributes, which is told what it says.</summary>
    internal sealed class Fields : PlainAgent
    {
        [Obs] private double number = 0.5;
        [Obs(".body.place")] private float[] place = new float[2];
        [Obs("@@.says")] private string says = "";
        [Obs] private string mine = "";
        private int steps;

        public Fields() : base("echo") { }
        public override void OnReset() => (says, steps) = ((string)Options.GetValueOrDefault("say") ?? "", 0);

        public override void OnAction(object action)
        {
            says = mine = (string)action;
            steps++;
        }

        public override void OnStepped()
        {
            number += 1;
            place = new[] { (float)number, (float)number };
            AddReward(0.5 * steps);
            if (steps == 2) Terminate();
            SendInfo(says);
        }
    }
}
