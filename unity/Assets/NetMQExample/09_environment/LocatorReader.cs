// Lesson 11, reading: the text of a locator, sign by sign, and at which column it is wrong.
//
//     .key  [key]  ["key"]                    a name is ASCII letters, digits and _; any other is quoted, with
//                                             the escapes of .NET's regular expressions
//     [0]  [-1]  [1:3]  [::2]                 numbers and slices, as Python has them
//     []                                      to append; after $ it is the whole
//     (0, 1:3, ..., newaxis)                  an index of numpy's; np.newaxis is the same
//     [0, 1:3, ..., np.newaxis]               the same; newaxis alone is a key
//
// Blanks between two signs are free. The Python side is netmq_example/locator/reader.py.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Text;
using System.Text.RegularExpressions;

namespace NetMQExample
{
    /// <summary>Goes through a text from left to right, and spells each part as in the canonical text.</summary>
    internal sealed class LocatorReader
    {
        // These are .NET's blanks, by name: other runtimes may have another list.
        private const string Blanks = @"[\t-\r \x85\xa0\u1680\u2000-\u200a\u2028\u2029\u202f\u205f\u3000]*";

        // Those of Regex.Unescape. Half a character (U+D800 to U+DFFF) is no text, neither as it stands nor escaped.
        private const string Hex = "[0-9A-Fa-f]";
        private const string Escape = @"\\[ -/:-@\[-^`{-~abefnrtv]|\\x" + Hex + @"{2}|\\c[@-\[\]^_a-z]|\\[0-7]{1,3}" +
            @"|\\u(?![Dd][89A-Fa-f])" + Hex + @"{4}|\\u[Dd][89ABab]" + Hex + @"{2}\\u[Dd][C-Fc-f]" + Hex + "{2}";

        private const string Character = @"[\ud800-\udbff][\udc00-\udfff]|[^\\\ud800-\udfff";
        private const string AnItem = "a number, a slice, ... or newaxis";

        private static readonly Regex Blank = new(@"\G" + Blanks);
        private static readonly Regex Name = new(@"\G[A-Za-z_][A-Za-z0-9_]*");
        private static readonly Regex Digits = new($@"\G[+-]?{Blanks}[0-9]+");
        private static readonly Regex NewAxis = new($@"\G(?:np{Blanks}\.{Blanks})?newaxis(?![A-Za-z0-9_])");

        // Begins with a name, and is still no key in brackets.
        private static readonly Regex NoKey = new($@"\G(?:np{Blanks}\.|newaxis{Blanks},)");
        private static readonly Regex InSingle = new($@"\G(?>{Character}']|{Escape})*");
        private static readonly Regex InDouble = new($@"\G(?>{Character}""]|{Escape})*");

        private readonly string text;
        private int at;

        public LocatorReader(string text) => this.text = text;

        public int At => at;
        public bool AtEnd => at == text.Length;

        /// <summary>Goes past this sign, if it stands next, after blanks. With what is expected, it must.</summary>
        public bool Sign(string sign, string expected = null)
        {
            Take(Blank);
            if (string.CompareOrdinal(text, at, sign, 0, sign.Length) != 0)
                return expected == null ? false : throw Wrong(expected);
            at += sign.Length;
            return true;
        }

        public LocatorException Wrong(string expected)
        {
            var length = at + 1 < text.Length && char.IsSurrogatePair(text[at], text[at + 1]) ? 2 : 1;
            var found = AtEnd ? "the end" : LocatorMapping.Quoted(text.Substring(at, length));
            return Fault(at, $"expected {expected}, found {found}");
        }

        /// <summary>The column counts characters: one beyond U+FFFF is two in a string of C#, one in Python.</summary>
        public LocatorException Fault(int place, string what)
        {
            var pairs = Regex.Matches(text.Substring(0, place), @"[\ud800-\udbff][\udc00-\udfff]").Count;
            return new LocatorException(place - pairs + 1, what);
        }

        /// <summary>The name that stands next, bare or quoted; null if there is none.</summary>
        public string TakeName()
        {
            var quote = Sign("'") ? "'" : Sign("\"") ? "\"" : null;
            if (quote == null) return Take(Name);
            var inside = Take(quote == "'" ? InSingle : InDouble);
            Sign(quote, $@"{quote} after the name; escapes are such as \\ \' \"" \n \uXXXX");
            return Regex.Unescape(inside);
        }

        /// <summary>As many steps as there are. Where a value is written, [] appends; else it is the whole
        /// of what is there.</summary>
        public string Path(bool appends)
        {
            var path = new StringBuilder();
            for (var dot = Sign("."); dot || Sign("["); dot = Sign("."))
            {
                Sign("");
                var step = dot ? LocatorMapping.Quoted(Take(Name) ?? throw Wrong("a name")) : Bracket();
                if (step != "" || appends) path.Append('[').Append(step).Append(']');
                if (step == "" && appends) return path.ToString();
            }
            while (Sign("(")) path.Append('(').Append(Items(")", AnItem)).Append(')');
            return path.ToString();
        }

        // The rest of [ … ]; "" if nothing is in it.
        private string Bracket()
        {
            var name = NoKey.IsMatch(text, at) ? null : TakeName();
            if (name == null) return Items("]", "a key, a number, a slice, ... or ']'");
            Sign("]", "']'");
            return LocatorMapping.Quoted(name);
        }

        private string Take(Regex pattern)
        {
            var found = pattern.Match(text, at);
            at += found.Length;
            return found.Success ? found.Value : null;
        }

        private int? Number(int? never = null)
        {
            Sign("");
            var before = at;
            var digits = Take(Digits);
            if (digits == null) return null;
            var number = Regex.Replace(digits, Blanks, "");
            var fits = int.TryParse(number, NumberStyles.AllowLeadingSign, CultureInfo.InvariantCulture, out var value);
            if (fits && value != never) return value;
            at = before;
            throw Wrong(fits ? "a step other than 0" : "a number from -2147483648 to 2147483647");
        }

        // 1, 1:3 or 1:9:2; null if there is neither a number nor a colon.
        private string Range()
        {
            var start = Number();
            if (!Sign(":")) return Text(start);
            var stop = Number();
            var step = Sign(":") ? Number(0) : null;
            // Backwards, a start of 0 is not where numpy would start by itself.
            if (start == 0 && !(step < 0)) start = null;
            return $"{Text(start)}:{Text(stop)}" + (step is null || step == 1 ? "" : $":{Text(step)}");
        }

        private static string Text(int? number) => number?.ToString(CultureInfo.InvariantCulture);

        private string Item(string expected)
        {
            if (Sign("...")) return "...";
            if (Take(NewAxis) != null) return "np.newaxis";
            return Range() ?? throw Wrong(expected);
        }

        // An index of numpy's up to its end; a comma may stand before that.
        private string Items(string end, string first)
        {
            var items = new List<string>();
            while (!Sign(end))
            {
                if (items.Count > 0)
                {
                    Sign(",", $"',' or '{end}'");
                    if (Sign(end)) break;
                }
                items.Add(Item(items.Count > 0 ? AnItem : first));
            }
            return string.Join(",", items);
        }
    }
}
