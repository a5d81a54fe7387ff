// Lesson 11, locators: where in whose observation a value goes, and which part of the value, as one line of text.
//
//     car@.speed                     into the observation of the agent car, under the key speed, the whole value
//     car@.speed = $[0]              the same, but of the value its first item alone
//     @@bus@.sun & bus@.lamp(2)      one value to two places: to all agents but bus, and to bus, in an array
//
//     var scope = Locator.Parse("car@.body");
//     Console.WriteLine(Locator.Parse(".speed", scope: scope));          prints: 'car'@['body']['speed'] = $
//
// It prints the canonical text: two locators mean the same if these are equal. The guide has the whole language, in
// docs/guide/11_locators.md; the Python side is netmq_example/locator. It needs neither NetMQ nor UnityEngine.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Text.RegularExpressions;

namespace NetMQExample
{
    /// <summary>What is wrong with a locator, in one line that says where.</summary>
    public sealed class LocatorException : ArgumentException
    {
        public LocatorException(int column, string text) : base($"column {column}: {text}") { }
    }

    /// <summary>One value to one place, whose paths are canonical text: Python takes the steps.</summary>
    public sealed class LocatorMapping
    {
        // Escaped in a canonical text: characters that end a line, write over it, turn it or cannot be seen.
        private static readonly Regex Unseen = new(
            @"[\\'\x00-\x1f\x7f-\x9f\xad\u061c\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb]" +
            @"|[\ud800-\udbff](?![\udc00-\udfff])|(?<![\ud800-\udbff])[\udc00-\udfff]");

        private readonly bool root;
        private readonly string destination, source;

        internal LocatorMapping(bool everyone, IEnumerable<string> agents, bool root, string destination, string source)
        {
            Everyone = everyone;
            this.root = root;
            this.destination = destination;
            this.source = source;
            Agents = agents.Distinct().OrderBy(agent => agent, StringComparer.Ordinal).ToArray();
        }

        /// <summary>All agents are meant, except those in <see cref="Agents"/>.</summary>
        public bool Everyone { get; }

        /// <summary>Whose observation. If there are none, it is the scope that says it.</summary>
        public IReadOnlyList<string> Agents { get; }

        /// <summary>Whether it says whose observation is meant.</summary>
        public bool Absolute => Everyone || Agents.Count > 0;

        public bool Appends => destination.EndsWith("[]", StringComparison.Ordinal);

        public bool Names(string agent) => Agents.Contains(agent) != Everyone;

        /// <summary>The canonical text in the observation of one agent, which is not named.</summary>
        internal string InIt => "@" + destination + " = $" + source;

        /// <summary>A name as it stands in a canonical text.</summary>
        internal static string Quoted(string name) => "'" + Unseen.Replace(name, match =>
            match.Value == "\\" || match.Value == "'" ? "\\" + match.Value : $"\\u{(int)match.Value[0]:x4}") + "'";

        public override string ToString()
        {
            var agents = string.Concat(Agents.Select(agent => Quoted(agent) + "@"));
            return (Everyone ? "@@" : root ? "@" : "") + agents + destination + " = $" + source;
        }

        /// <summary>The characters that could continue a path with this end.</summary>
        internal static string After(string path) => path.EndsWith("[]", StringComparison.Ordinal) ? ""
            : path.EndsWith(")", StringComparison.Ordinal) ? "'(', " : "'.', '[', '(', ";

        // The name of a field is the key where nothing says a place.
        internal LocatorMapping Named(string name) =>
            string.IsNullOrEmpty(name) || Absolute || root || destination != ""
            ? this : new LocatorMapping(false, Agents, false, $"[{Quoted(name)}]", source);

        // Put where the scope says.
        internal LocatorMapping Joined(LocatorReader reader, int at, LocatorMapping scope)
        {
            var before = root ? "" : scope.destination;
            var after = destination;
            if (scope.source != "")
                throw reader.Fault(at, "expected a scope without a source: nothing after '$'");
            if (after != "" && before.EndsWith("[]", StringComparison.Ordinal))
                throw reader.Fault(at, "expected nothing after the [] of the scope");
            if (after != "" && after[0] != '(' && before.EndsWith(")", StringComparison.Ordinal))
                throw reader.Fault(at, "expected only (…) after the (…) of the scope");
            var relative = !scope.Absolute && (root || scope.root);
            return new LocatorMapping(scope.Everyone, scope.Agents, relative, before + after, source);
        }
    }

    /// <summary>Its mappings in the order of their canonical texts, in which they are also written.</summary>
    public sealed class Locator
    {
        private readonly string text;

        private Locator(IEnumerable<LocatorMapping> mappings)
        {
            // Ordinal: the same on every machine, whatever its language.
            Mappings = mappings.OrderBy(mapping => mapping.ToString(), StringComparer.Ordinal).ToArray();
            text = string.Join(" & ", Mappings);
        }

        public IReadOnlyList<LocatorMapping> Mappings { get; }

        /// <summary>Whether it says whose observation is meant; else it cannot be written anywhere.</summary>
        public bool Absolute => Mappings.All(mapping => mapping.Absolute);

        /// <summary>The locator that a text means. The name is the key where the text has no place at all, such as the
        /// name of a field. With a scope, what is relative is put there: once for each mapping of the scope.
        /// Null is as an empty text.</summary>
        /// <exception cref="LocatorException">Where the text is wrong, and what was expected there.</exception>
        public static Locator Parse(string text, string name = "", Locator scope = null)
        {
            var reader = new LocatorReader(text ?? "");
            var mappings = new List<LocatorMapping>();
            string more;
            do
            {
                reader.Sign("");
                var at = reader.At;
                var mapping = Read(reader, out more).Named(name);
                if (mapping.Absolute || scope == null) mappings.Add(mapping);
                else mappings.AddRange(scope.Mappings.Select(place => mapping.Joined(reader, at, place)));
            }
            while (reader.Sign("&"));
            return reader.AtEnd ? new Locator(mappings) : throw reader.Wrong(more + "'&' or the end");
        }

        // The mapping that stands next, and what could have continued it.
        private static LocatorMapping Read(LocatorReader reader, out string more)
        {
            var everyone = reader.Sign("@@");
            var root = !everyone && reader.Sign("@");
            var agents = new List<string>();
            for (var agent = root ? null : reader.TakeName(); agent != null; agent = reader.TakeName())
            {
                agents.Add(agent);
                reader.Sign("@", "'@' after the name of an agent");
            }
            var destination = reader.Path(true);
            var source = "";
            more = LocatorMapping.After(destination) + "'=', ";
            if (reader.Sign("="))
            {
                reader.Sign("$", "'$'");
                source = reader.Path(false);
                more = LocatorMapping.After(source);
            }
            return new LocatorMapping(everyone, agents, root, destination, source);
        }

        public override string ToString() => text;
    }
}
