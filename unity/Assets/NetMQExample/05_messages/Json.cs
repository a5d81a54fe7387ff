// JSON text to plain objects and back, as much as the header of Message.cs needs.
//
// Take home: this file, with Message.cs. It needs neither NetMQ nor UnityEngine, and it uses no reflection, so IL2CPP
// has nothing to strip. Unity's JsonUtility would be shorter, but it leaves a field that is missing or misspelled at its
// standard value without a word, reads no object whose names are not known beforehand, and exists only inside Unity.
// Texts are string, whole numbers long, other numbers double, lists List<object>, objects Dictionary<string, object>.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Globalization;
using System.Text;
using System.Text.RegularExpressions;

namespace NetMQExample
{
    /// <summary>Reads and writes JSON. Numbers never depend on the machine's language.</summary>
    public static class Json
    {
        // Deeper than any header, and far from what the stack can bear.
        private const int MaxDepth = 32;
        private const string Escapes = "\"\\/bfnrt", Escaped = "\"\\/\b\f\n\r\t";

        /// <summary>Reads a whole JSON text.</summary>
        /// <exception cref="FormatException">It is not JSON; the message says what is wrong where.</exception>
        public static object Read(string text)
        {
            var reader = new Reader(text);
            var value = reader.Value(0);
            return reader.AtEnd ? value : throw reader.Error("nothing more");
        }

        /// <summary>Writes a value as JSON, in ASCII: letters beyond it become \u1234.</summary>
        public static void Write(StringBuilder to, object value)
        {
            if (value is string text)
            {
                to.Append('"');
                foreach (var c in text)
                {
                    var escape = c == '/' ? -1 : Escaped.IndexOf(c);
                    if (escape >= 0) to.Append('\\').Append(Escapes[escape]);
                    else if (c < ' ' || c > '~') to.Append("\\u").Append(((int)c).ToString("x4", CultureInfo.InvariantCulture));
                    else to.Append(c);
                }
                to.Append('"');
            }
            else if (value is bool yes) to.Append(yes ? "true" : "false");
            else if (value is float || value is double) to.Append(Real(Convert.ToDouble(value, CultureInfo.InvariantCulture)));
            else if (value is int || value is long) to.Append(Convert.ToString(value, CultureInfo.InvariantCulture));
            else if (value is Dictionary<string, object> fields)
            {
                var before = '{';
                foreach (var field in fields)
                {
                    Write(to.Append(before), field.Key);
                    Write(to.Append(':'), field.Value);
                    before = ',';
                }
                to.Append(before == '{' ? "{}" : "}");
            }
            else if (value is IEnumerable items)
            {
                var before = '[';
                foreach (var item in items)
                {
                    Write(to.Append(before), item);
                    before = ',';
                }
                to.Append(before == '[' ? "[]" : "]");
            }
            else throw new ArgumentException($"a {value?.GetType().Name ?? "null"} has no place in a header");
        }

        /// <summary>A word that a peer sent, for an error's text: in ASCII, and cut to a readable length.</summary>
        public static string Shown(string word)
        {
            var text = new StringBuilder();
            Write(text, word.Substring(0, Math.Min(word.Length, 40)));
            return text.ToString(1, text.Length - 2);
        }

        private static string Real(double value)
        {
            if (double.IsNaN(value) || double.IsInfinity(value)) throw new ArgumentException("JSON has no NaN and no infinity");
            var text = value.ToString("R", CultureInfo.InvariantCulture);
            // 1 would come back as a whole number.
            return text.IndexOfAny(new[] { '.', 'E' }) < 0 ? text + ".0" : text;
        }

        private sealed class Reader
        {
            private static readonly Regex NumberPattern = new Regex(@"\G-?(0|[1-9][0-9]*)(\.[0-9]+)?([eE][+-]?[0-9]+)?");
            private readonly string text;
            private int at;

            public Reader(string text) => this.text = text;

            public bool AtEnd => Peek() == '\0' && at == text.Length;

            public FormatException Error(string wanted) => new FormatException($"expected {wanted} at character {at}");

            public object Value(int depth)
            {
                if (depth > MaxDepth) throw Error($"at most {MaxDepth} levels");
                switch (Peek())
                {
                    case '{':
                        var fields = new Dictionary<string, object>();
                        for (at++; Peek() != '}';)
                        {
                            if (fields.Count > 0) Take(',');
                            var name = Text();
                            Take(':');
                            fields[name] = Value(depth + 1);
                        }
                        at++;
                        return fields;
                    case '[':
                        var items = new List<object>();
                        for (at++; Peek() != ']';)
                        {
                            if (items.Count > 0) Take(',');
                            items.Add(Value(depth + 1));
                        }
                        at++;
                        return items;
                    case '"': return Text();
                    case 't': return Word("true", true);
                    case 'f': return Word("false", false);
                    case 'n': return Word("null", null);
                    default: return Number();
                }
            }

            private char Peek()
            {
                while (at < text.Length && " \t\n\r".IndexOf(text[at]) >= 0) at++;
                return at < text.Length ? text[at] : '\0';
            }

            private void Take(char wanted)
            {
                if (Peek() != wanted) throw Error($"'{wanted}'");
                at++;
            }

            private object Word(string word, object value)
            {
                if (string.CompareOrdinal(text, at, word, 0, word.Length) != 0) throw Error("a value");
                at += word.Length;
                return value;
            }

            private object Number()
            {
                var match = NumberPattern.Match(text, at);
                if (!match.Success) throw Error("a value");
                at += match.Length;
                var culture = CultureInfo.InvariantCulture;
                if (match.Groups[2].Success || match.Groups[3].Success)
                    return double.TryParse(match.Value, NumberStyles.Float, culture, out var real) ? real : double.PositiveInfinity;
                // What no long can hold is no exact number anywhere, and Message refuses this one as well.
                return long.TryParse(match.Value, NumberStyles.AllowLeadingSign, culture, out var whole) ? whole : long.MaxValue;
            }

            private string Text()
            {
                Take('"');
                var result = new StringBuilder();
                for (; at < text.Length && text[at] >= ' '; at++)
                {
                    if (text[at] == '"')
                    {
                        at++;
                        return result.ToString();
                    }
                    result.Append(text[at] == '\\' ? Escape() : text[at]);
                }
                throw Error("'\"'");
            }

            private char Escape()
            {
                at++;
                var escape = at < text.Length ? Escapes.IndexOf(text[at]) : -1;
                if (escape >= 0) return Escaped[escape];
                if (at + 4 < text.Length && text[at] == 'u' &&
                    ushort.TryParse(text.Substring(at + 1, 4), NumberStyles.AllowHexSpecifier, CultureInfo.InvariantCulture, out var code))
                {
                    at += 4;
                    return (char)code;
                }
                throw Error("an escape");
            }
        }
    }
}
