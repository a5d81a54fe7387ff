// The C# of some lessons gets bytes, texts and calls that no option of a terminal client shows, in one process:
//
//     dotnet checks.dll locators …          mono checks.dll sidechannels …
//
// Which words come after the first, each file says.
using System;
using System.Globalization;
using System.Linq;

namespace NetMQExample.Tests
{
    internal static class Program
    {
        /// <summary>A machine where 0.5 is written 0,5 must read, write and print the same.</summary>
        public static void WriteNumbersInGerman()
        {
            var german = (CultureInfo)CultureInfo.InvariantCulture.Clone();
            (german.NumberFormat.NumberDecimalSeparator, german.NumberFormat.NumberGroupSeparator) = (",", ".");
            CultureInfo.CurrentCulture = german;
        }

        /// <summary>The input's lines, each with its answer; or with the code with which it is refused.</summary>
        public static void EachLine(Func<string, string> answer)
        {
            for (var line = Console.ReadLine(); line != null; line = Console.ReadLine())
            {
                try { Console.WriteLine(answer(line)); }
                catch (MessageException e) { Console.WriteLine($"error {e.Code}"); }
            }
        }

        public static int Whole(string text) => int.Parse(text, CultureInfo.InvariantCulture);

        private static int Main(string[] words)
        {
            var rest = words.Skip(1).ToArray();
            switch (words[0])
            {
                case "background": return BackgroundClientChecks.Run(rest);
                case "each": EachRun.Run(rest[0]); return 0;
                case "jobs": JobChecks.Run(rest[0]); return 0;
                case "locators": LocatorChecks.Run(); return 0;
                case "messages": MessageChecks.Run(rest); return 0;
                case "observations": ObservationChecks.Run(rest); return 0;
                case "office": Office.Run(rest[0], rest[1], rest[3]); return 0;
                case "records": RecordChecks.Run(rest); return 0;
                case "rules": RuleChecks.Run(); return 0;
                case "scene": Scenes.Run(rest[0], rest[1], rest.Skip(2).ToArray()); return 0;
                case "server": return ServerChecks.Run(rest);
                case "sidechannels": SideChannelChecks.Run(rest); return 0;
                default: throw new ArgumentException($"no checks of {words[0]}");
            }
        }
    }

    /// <summary>Bytes in a line of text: two digits each, and a minus where there are none.</summary>
    internal static class Hex
    {
        public static byte[] Bytes(string digits) => digits == "-" ? new byte[0]
            : Enumerable.Range(0, digits.Length / 2)
                .Select(i => Convert.ToByte(digits.Substring(2 * i, 2), 16)).ToArray();

        public static string Digits(byte[] bytes) =>
            bytes.Length == 0 ? "-" : BitConverter.ToString(bytes).Replace("-", "").ToLowerInvariant();
    }
}
