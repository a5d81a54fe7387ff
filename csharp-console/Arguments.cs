// The options of a terminal client: declared by asking for them, so that a twin lists each one once.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;

namespace NetMQExample.Terminal
{
    /// <summary>The command line was wrong; the message says how. Exit code 2.</summary>
    internal sealed class UsageException : Exception
    {
        public UsageException(string message) : base(message) { }
    }

    /// <summary>Options such as <c>--count 3</c> or <c>--count=3</c>, read in the invariant culture.</summary>
    internal sealed class Arguments
    {
        private readonly List<string> rest = new();
        private readonly List<string> declared = new();

        public Arguments(IEnumerable<string> words)
        {
            foreach (var word in words)
            {
                var equals = word.StartsWith("--", StringComparison.Ordinal) ? word.IndexOf('=') : -1;
                if (equals < 0) rest.Add(word);
                else rest.AddRange(new[] { word[..equals], word[(equals + 1)..] });
            }
        }

        public bool Flag(string name)
        {
            declared.Add($"--{name}");
            return rest.Remove($"--{name}");
        }

        /// <summary>Whether it was given, also with a value that is the standard one.</summary>
        public bool Has(string name) => rest.Contains($"--{name}");

        public string Text(string name, string standard)
        {
            declared.Add($"--{name} {standard}");
            var at = rest.IndexOf($"--{name}");
            if (at < 0) return standard;
            if (at + 1 == rest.Count) throw new UsageException($"--{name} needs a value, such as: --{name} {standard}");
            var value = rest[at + 1];
            rest.RemoveRange(at, 2);
            return value;
        }

        public int Whole(string name, int standard)
        {
            var text = Text(name, standard.ToString(CultureInfo.InvariantCulture));
            return int.TryParse(text, NumberStyles.None, CultureInfo.InvariantCulture, out var value)
                ? value
                : throw new UsageException($"--{name} takes a whole number from 0, not '{text}'");
        }

        public TimeSpan Seconds(string name, double standard)
        {
            var text = Text(name, standard.ToString(CultureInfo.InvariantCulture));
            const NumberStyles plain = NumberStyles.AllowDecimalPoint;
            // A day is longer than anybody waits, and short enough for every timer.
            return double.TryParse(text, plain, CultureInfo.InvariantCulture, out var value) && value <= 86400
                ? TimeSpan.FromSeconds(value)
                : throw new UsageException($"--{name} takes seconds, such as 0.5, not '{text}'");
        }

        /// <summary>What is left, as name and value: <c>--count 3</c>; a switch alone, such as <c>--drive</c>, is true.</summary>
        public IEnumerable<(string Name, string Value)> TakeTheRest()
        {
            while (rest.Count > 0 && rest[0].StartsWith("--", StringComparison.Ordinal) && !rest.Contains("--help"))
            {
                var alone = rest.Count == 1 || rest[1].StartsWith("--", StringComparison.Ordinal);
                yield return (rest[0][2..], alone ? "true" : rest[1]);
                rest.RemoveRange(0, alone ? 1 : 2);
            }
        }

        /// <summary>Call it after the last option: an unknown word, or --help, ends the program here.</summary>
        public void RefuseTheRest()
        {
            if (rest.Count == 0) return;
            var known = "options and what they are when left out: " + string.Join("  ", declared);
            throw new UsageException(rest.Contains("--help") ? known : $"unknown: {rest.First()}; {known}");
        }
    }
}
