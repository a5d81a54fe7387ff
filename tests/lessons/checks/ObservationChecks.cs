// test_11_trees.py and test_11_observations.py ask this of the C# side:
//
//     trees         each line of the input is a value (MessageTree.cs) in hexadecimal digits; it is read, and
//                   printed is the same value, written again, or "error" and the code
//     row           each line has a reset, and then locators and values in turn, in hexadecimal digits; printed is the
//                   answer of a simulator whose only agent, it's, sees them
//     attributes    what is seen of some classes, line by line, and what is wrong with others
//     world NAME … --endpoint E       simulates agents of these names, which do what they are told
using System;
using System.Linq;
using System.Text;

namespace NetMQExample.Tests
{
    internal static class ObservationChecks
    {
        public static void Run(string[] words)
        {
            Program.WriteNumbersInGerman();
            if (words[0] == "trees") Program.EachLine(line => Shown(MessageTree.Read(Hex.Bytes(line))));
            else if (words[0] == "row") Program.EachLine(Row);
            else if (words[0] == "world") World.Run(words.Last(), words.Skip(1).Take(words.Length - 3));
            else Attributes.Print();
        }

        private static string Row(string line)
        {
            var words = line.Split(' ').Select(Hex.Bytes).ToArray();
            var values = words.Skip(1).Where((_, i) => i % 2 == 1).Select(data => MessageTree.Read(data)).ToArray();
            var sources = values.Select((value, i) => new Source(
                "given", Locator.Parse(Encoding.UTF8.GetString(words[1 + 2 * i])), () => value)).ToArray();
            var simulator = new SceneSimulator("Given", 1, new[] { new Nobody() }, sensors: sources);
            simulator.Hello();
            var request = new StepRequest();
            request.Read(words[0]);
            simulator.Answer(request);
            return Hex.Digits(simulator.Frame.ToArray());
        }

        internal static string Shown(object value) => Hex.Digits(MessageTree.Write(value));

        private sealed class Nobody : PlainAgent
        {
            public Nobody() : base("it's") { }
        }
    }
}
