// Reads JSON in UTF-8 where it lies, forwards and word by word: it looks up no class by its name, so a message can make
// nothing but texts, numbers, true, false, lists and dictionaries, and IL2CPP has nothing to strip.
//
// Two languages must agree on what is a message, so it takes what RFC 8259 has, and no more: no comments, no NaN, no
// comma too many, and no \ud800, which is half a character. The whole text is looked at first. What reads it afterwards
// knows that every word is right.
using System;
using System.Buffers.Text;
using System.Collections.Generic;
using System.Globalization;
using System.Text;

namespace NetMQExample
{
    /// <summary>Whole numbers are long, other numbers double, lists List&lt;object&gt;, objects Dictionary.</summary>
    internal ref struct MessageReader
    {
        // Python takes no longer whole number, and no header nests as deep.
        private const int MostDigits = 4300, Deepest = 64;
        private const string Escapes = "\"\\/bfnrt", Meant = "\"\\/\b\f\n\r\t";
        private static readonly UTF8Encoding Utf8 = new UTF8Encoding(false, true);
        private static readonly object True = true, False = false;
        // The same few names come with each message, and need no new string each time. Threads may share them: a string
        // that another one has replaced meanwhile is still right.
        private static readonly string[] Known = new string[64];

        private readonly ReadOnlySpan<byte> bytes;

        /// <summary>Looks at a whole JSON text, and goes to its beginning.</summary>
        /// <exception cref="MessageException">It is none, or deeper than any header.</exception>
        public MessageReader(ReadOnlySpan<byte> bytes)
        {
            this.bytes = bytes;
            At = 0;
            try
            {
                Pass(Deepest);
                if (Next() >= 0) throw new FormatException("more follows it");
            }
            catch (Exception e) when (e is FormatException || e is ArgumentException)
            {
                throw new MessageException("bad-json", $"the header is not JSON in UTF-8: {e.Message}");
            }
            At = 0;
        }

        /// <summary>Where it is.</summary>
        public int At { get; set; }

        /// <summary>Goes to the value of a field.</summary>
        /// <param name="name">The field, for an error.</param>
        /// <param name="at">Where its value begins; 0 where there is none.</param>
        /// <param name="first">The byte that it must begin with.</param>
        public void Go(string name, int at, char first)
        {
            if (at == 0) throw new MessageException("missing-field", $"there is no '{name}'");
            At = at;
            if (Next() == first) return;
            var what = first == '"' ? "a text" : first == '[' ? "a list" : "an object";
            throw new MessageException("wrong-type", $"'{name}' must be {what}");
        }

        /// <summary>The text of a field.</summary>
        public string Text(string name, int at)
        {
            Go(name, at, '"');
            return Text();
        }

        /// <summary>The whole number of a field.</summary>
        public long Whole(string name, int at)
        {
            At = at;
            if (at == 0) throw new MessageException("missing-field", $"there is no '{name}'");
            if (IsWhole(out var whole, out _)) return whole;
            throw new MessageException("wrong-type", $"'{name}' must be a whole number");
        }

        /// <summary>An object is expected here, with this field.</summary>
        public void Open(string name)
        {
            if (Next() != '{') throw new MessageException("wrong-type", $"expected an object with '{name}'");
        }

        /// <summary>Goes past a value.</summary>
        /// <returns>Where that begins.</returns>
        public int Skip()
        {
            Next();
            var start = At;
            Pass(Deepest);
            return start;
        }

        /// <summary>Goes to the next item of a list, or name of an object, from its bracket on.</summary>
        /// <returns>False behind the last one.</returns>
        public bool More()
        {
            var word = Next();
            At++;
            if (word == ',') return true;
            if (word != '[' && word != '{') return false;
            if (Next() != word + 2) return true;
            At++;
            return false;
        }

        /// <summary>The name of a field, whose value follows.</summary>
        public string Name()
        {
            var name = Text();
            Next();
            At++;
            return name;
        }

        /// <summary>Any value.</summary>
        public object Value()
        {
            switch (Next())
            {
                case '{':
                    var fields = new Dictionary<string, object>();
                    while (More())
                    {
                        var name = Name();
                        fields[name] = Value();
                    }
                    return fields;
                case '[':
                    var items = new List<object>();
                    while (More()) items.Add(Value());
                    return items;
                case '"':
                    return Text();
                case 't':
                    At += 4;
                    return True;
                case 'f':
                    At += 5;
                    return False;
                case 'n':
                    At += 4;
                    return null;
                default:
                    return IsWhole(out var whole, out var real) ? whole : (object)real;
            }
        }

        /// <summary>A number, if one begins here.</summary>
        /// <param name="whole">A number that no long can hold is exact nowhere: it is a long that nobody takes.</param>
        /// <param name="real">One that is not whole; NaN where there is none.</param>
        public bool IsWhole(out long whole, out double real)
        {
            (whole, real) = (0, double.NaN);
            var word = Next();
            if (word != '-' && !IsDigit(word)) return false;
            var start = At;
            Pass(0);
            var digits = bytes.Slice(start, At - start);
            if (digits.IndexOfAny((byte)'.', (byte)'e', (byte)'E') < 0)
            {
                if (!Utf8Parser.TryParse(digits, out whole, out _)) whole = long.MaxValue;
                return true;
            }
            Span<char> letters = digits.Length <= 64 ? stackalloc char[digits.Length] : new char[digits.Length];
            for (var i = 0; i < digits.Length; i++) letters[i] = (char)digits[i];
            // Where .NET does not make it infinite, as Mono does not.
            if (!double.TryParse(letters, NumberStyles.Float, CultureInfo.InvariantCulture, out real))
                real = double.PositiveInfinity;
            return false;
        }

        /// <summary>A text, if one begins here; otherwise null.</summary>
        public string Text()
        {
            if (Next() != '"') return null;
            StringBuilder text = null;
            for (At++; ;)
            {
                var letters = bytes.Slice(At, bytes.Slice(At).IndexOfAny((byte)'"', (byte)'\\'));
                At += letters.Length + 1;
                var last = bytes[At - 1] == '"';
                if (last && text == null) return Kept(letters);
                text ??= new StringBuilder();
                text.Append(Utf8.GetString(letters));
                if (last) return text.ToString();
                text.Append(Escaped());
            }
        }

        private static string Kept(ReadOnlySpan<byte> letters)
        {
            if (letters.Length > 32) return Utf8.GetString(letters);
            var hash = letters.Length;
            foreach (var letter in letters) hash = hash * 31 + letter;
            ref var known = ref Known[hash & (Known.Length - 1)];
            var found = known;
            if (found == null || !Same(found, letters)) known = found = Utf8.GetString(letters);
            return found;
        }

        private static bool Same(string text, ReadOnlySpan<byte> letters)
        {
            if (text.Length != letters.Length) return false;
            for (var i = 0; i < letters.Length; i++)
                if (text[i] != letters[i] || letters[i] > 127) return false;
            return true;
        }

        /// <summary>The byte that the next word begins with; -1 at the end.</summary>
        public int Next()
        {
            for (; At < bytes.Length; At++)
            {
                var letter = bytes[At];
                if (letter != ' ' && letter != '\n' && letter != '\r' && letter != '\t') return letter;
            }
            return -1;
        }

        // Whether this byte comes now, which is passed then.
        private bool Take(int letter)
        {
            if (At == bytes.Length || bytes[At] != letter) return false;
            At++;
            return true;
        }

        private void Expect(int letter)
        {
            if (Next() != letter) throw new FormatException($"'{(char)letter}' is missing at byte {At}");
            At++;
        }

        // Goes past a value, and throws where it is none.
        private void Pass(int deeper)
        {
            switch (Next())
            {
                case '{':
                case '[':
                    if (deeper == 0) throw new FormatException($"it nests more than {Deepest} levels deep");
                    var close = bytes[At++] + 2;
                    if (Next() != close)
                    {
                        do
                        {
                            if (close == '}')
                            {
                                PassText();
                                Expect(':');
                            }
                            Pass(deeper - 1);
                            Next();
                        }
                        while (Take(','));
                    }
                    Expect(close);
                    break;
                case '"':
                    PassText();
                    break;
                case 't':
                    PassWord("true");
                    break;
                case 'f':
                    PassWord("false");
                    break;
                case 'n':
                    PassWord("null");
                    break;
                default:
                    PassNumber();
                    break;
            }
        }

        private void PassWord(string word)
        {
            foreach (var letter in word)
                if (!Take(letter)) throw Wrong();
        }

        private void PassText()
        {
            Expect('"');
            var start = At;
            for (; ; At++)
            {
                if (At == bytes.Length || bytes[At] < ' ') throw Wrong();
                if (bytes[At] == '"') break;
                if (bytes[At] != '\\') continue;
                At++;
                var one = Escaped();
                if (char.IsHighSurrogate(one) && Take('\\') && char.IsLowSurrogate(Escaped())) one = ' ';
                if (char.IsSurrogate(one)) throw new FormatException($"half a character before byte {At}");
                At--;
            }
            // Throws where it is no UTF-8.
            Utf8.GetCharCount(bytes.Slice(start, At - start));
            At++;
        }

        // What stands behind a backslash.
        private char Escaped()
        {
            for (var i = 0; i < Escapes.Length; i++)
                if (Take(Escapes[i])) return Meant[i];
            if (!Take('u') || !Utf8Parser.TryParse(bytes.Slice(At, Math.Min(4, bytes.Length - At)), out ushort code,
                out var length, 'x') || length < 4) throw Wrong();
            At += 4;
            return (char)code;
        }

        private void PassNumber()
        {
            Take('-');
            var whole = Take('0') ? 1 : PassDigits();
            var point = Take('.') ? PassDigits() : 0;
            if (Take('e') || Take('E'))
            {
                if (!Take('+')) Take('-');
                PassDigits();
            }
            else if (point == 0 && whole > MostDigits) throw new FormatException($"{whole} digits are too many");
        }

        private int PassDigits()
        {
            var start = At;
            while (At < bytes.Length && IsDigit(bytes[At])) At++;
            return At > start ? At - start : throw Wrong();
        }

        private static bool IsDigit(int letter) => letter >= '0' && letter <= '9';

        private FormatException Wrong() => new FormatException($"none of JSON's words at byte {At}");
    }
}
