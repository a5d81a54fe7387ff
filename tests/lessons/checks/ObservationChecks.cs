// test_11_trees.py and test_11_observations.py ask this of the C# side:
//
//     trees         each line of the input is a value (MessageTree.cs) in hexadecimal digits; it is read, and
//                   printed is the same value, written again, or "error" and the code
//     pairs         each line has texts and values, in turn, in hexadecimal digits; printed is what WritePairs makes of
//                   them
//     attributes    what is seen of some classes, line by line, and what is wrong with others
//     world [NAME …] --endpoint E    simulates agents that do what they are told: a, b and c, or those
using System;
using System.Buffers;
using System.Globalization;
using System.Linq;
using System.Text;

namespace NetMQExample.Tests
{
    internal static class ObservationChecks
    {
        public static void Run(string[] words)
        {
            Program.WriteNumbersInGerman();
            if (words[0] == "trees")
                for (var line = Console.ReadLine(); line != null; line = Console.ReadLine())
                    Console.WriteLine(Again(line));
            else if (words[0] == "pairs")
                for (var line = Console.ReadLine(); line != null; line = Console.ReadLine())
                    Console.WriteLine(Pairs(line));
            else if (words[0] == "world") World.Run(words.Last(), words.Skip(1).Take(words.Length - 3));
            else Attributes.Print();
        }

        private static string Again(string line)
        {
            try
            {
                return Shown(MessageTree.Read(Hex.Bytes(line)));
            }
            catch (MessageException e)
            {
                return $"error {e.Code}";
            }
        }

        private static string Pairs(string line)
        {
            throw new NotSupportedException($"a row of locators is written by a simulator: {line}");
        }

        internal static string Shown(object value) => Hex.Digits(MessageTree.Write(value));
    }
}
