// The options of a terminal client: declared by asking for them, so that a client lists each one once.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;

namespace NetMQExample.Terminal
{
    /// <summary>The command line was wrong; the message says how. Exit code 2.</summary>
    internal sealed class UsageException : ArgumentException
    {
        public UsageException(string message) : base(message) { }
    }

    /// <summary>Options such as <c>--count 3</c> or <c>--count=3</c>, read in the invariant culture.</summary>
    internal sealed class Arguments
    {
        private readonly List<string> rest;
        private readonly List<string> declared = new();

        public Arguments(IEnumerable<string> words) => rest = words.ToList();

        public bool Flag(string name)
        {
            declared.Add($"--{name}");
            return rest.Remove($"--{name}");
        }

        /// <summary>Whether it was given, also with a value that is the standard one.</summary>
        public bool Has(string name) => rest.Any(word => NameOf(word) == $"--{name}");

        public string Text(string name, string standard)
        {
            declared.Add($"--{name} {standard}");
            var at = rest.FindIndex(word => NameOf(word) == $"--{name}");
            if (at < 0) return standard;
            return TakeValue(at) ?? throw new UsageException($"--{name} needs a value, such as: --{name} {standard}");
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

        /// <summary>What is left, as name and value: <c>--count 3</c>; a switch alone, such as <c>--drive</c>, is
        /// true.</summary>
        public IEnumerable<(string Name, string Value)> TakeTheRest()
        {
            while (rest.Count > 0 && rest[0].StartsWith("--", StringComparison.Ordinal) && !rest.Contains("--help"))
            {
                var name = NameOf(rest[0])[2..];
                var alone = rest[0].IndexOf('=') < 0
                    && (rest.Count == 1 || rest[1].StartsWith("--", StringComparison.Ordinal));
                if (alone) rest.RemoveAt(0);
                yield return (name, alone ? "true" : TakeValue(0)!);
            }
        }

        /// <summary>Call it after the last option: an unknown word, or --help, ends the program here.</summary>
        public void RefuseTheRest()
        {
            if (rest.Count == 0) return;
            var known = "options and their defaults: " + string.Join("  ", declared);
            throw new UsageException(rest.Contains("--help") ? known : $"unknown: {NameOf(rest.First())}; {known}");
        }

        private static string NameOf(string word) =>
            word.StartsWith("--", StringComparison.Ordinal) ? word.Split('=')[0] : word;

        // A value after the equals sign may begin with dashes: a CURVE key does, once in some thousand.
        private string? TakeValue(int at)
        {
            var word = rest[at];
            var equals = word.IndexOf('=');
            rest.RemoveAt(at);
            if (equals >= 0) return word[(equals + 1)..];
            if (at == rest.Count) return null;
            var value = rest[at];
            rest.RemoveAt(at);
            return value;
        }
    }
}
