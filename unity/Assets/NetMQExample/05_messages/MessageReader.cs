// Reads JSON in UTF-8 where it lies, forwards and word by word: it looks up no class by its name, so a message can make
// nothing but texts, numbers, true, false, lists and dictionaries, and IL2CPP has nothing to strip.
//
// Two languages must agree on what is a message, so it takes what RFC 8259 has, and no more: no comments, no NaN, no
// comma too many, and no \ud800, which is half a character. The whole text is looked at first, so that its fields can
// be read in any order.
using System;
using System.Buffers.Text;
using System.Collections.Generic;
using System.Globalization;
using System.Runtime.InteropServices;
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

        // Only read. Mono lacks the indexer of a ReadOnlySpan that C# asks for.
        private readonly Span<byte> bytes;

        /// <summary>Looks at a whole JSON text, and goes to its beginning.</summary>
        /// <exception cref="MessageException">It is none, or deeper than any header.</exception>
        public MessageReader(ReadOnlySpan<byte> bytes)
        {
            this.bytes = MemoryMarshal.CreateSpan(ref MemoryMarshal.GetReference(bytes), bytes.Length);
            At = 0;
            Skip();
            if (Next() >= 0) throw Wrong("more follows it");
            At = 0;
        }

        /// <summary>Where it is.</summary>
        public int At { get; set; }

        /// <summary>Goes to the value of a field. Of two with one name the last counts.</summary>
        /// <param name="from">Where the object begins.</param>
        /// <param name="name">The field.</param>
        /// <param name="what">Its kind: "text", "whole number", "list" or "dict".</param>
        public void Go(int from, string name, string what)
        {
            var found = -1;
            At = from;
            if (Next() != '{') throw new MessageException("wrong-type", $"expected an object with '{name}'");
            for (var more = Into(); more; more = More('}'))
            {
                if (Name() == name) found = At;
                Skip();
            }
            if (found < 0) throw new MessageException("missing-field", $"there is no '{name}'");
            At = found;
            var word = Skip();
            var kind = word[0] == '"' ? "text" : word[0] == '[' ? "list" : word[0] == '{' ? "dict"
                : IsWhole(word) ? "whole number" : "";
            if (kind != what) throw new MessageException("wrong-type", $"'{name}' must be a {what}");
            At = found;
        }

        /// <summary>Goes into a list, or an object, that begins here.</summary>
        /// <returns>Whether there is anything in it; then <see cref="More"/> goes on.</returns>
        public bool Into()
        {
            var close = Next() + 2;
            At++;
            if (Next() != close) return true;
            At++;
            return false;
        }

        /// <summary>Goes to the next item of a list, or name of an object, from the end of the one before.</summary>
        /// <returns>False behind the last one.</returns>
        public bool More(int close)
        {
            Next();
            if (Take(',')) return true;
            Expect(close);
            return false;
        }

        /// <summary>The name of a field, whose value follows.</summary>
        public string Name(bool make = true)
        {
            var name = Text(make);
            Expect(':');
            return name;
        }

        /// <summary>Any value.</summary>
        public object Value() => Read(true, Deepest);

        /// <summary>Goes past a value.</summary>
        /// <returns>Its bytes.</returns>
        public Span<byte> Skip()
        {
            Next();
            var start = At;
            Read(false, Deepest);
            return bytes.Slice(start, At - start);
        }

        /// <summary>Whether this word is a whole number.</summary>
        public static bool IsWhole(Span<byte> word) =>
            word[0] <= '9' && word[0] != '"' && word.IndexOfAny((byte)'.', (byte)'e', (byte)'E') < 0;

        /// <summary>Its number. One that no long can hold is exact nowhere: it is a long that nobody takes.</summary>
        public static long Whole(Span<byte> word) =>
            Utf8Parser.TryParse(word, out long number, out _) ? number : long.MaxValue;

        /// <summary>Any number.</summary>
        public static double Real(Span<byte> word)
        {
            Span<char> letters = word.Length <= 64 ? stackalloc char[word.Length] : new char[word.Length];
            for (var i = 0; i < word.Length; i++) letters[i] = (char)word[i];
            // Too large a number is infinite to .NET, and none at all to Mono.
            return double.TryParse(letters, NumberStyles.Float, CultureInfo.InvariantCulture, out var number)
                ? number : double.PositiveInfinity;
        }

        private static string Kept(Span<byte> letters)
        {
            if (letters.Length > 32) return Utf8.GetString(letters);
            var hash = letters.Length;
            foreach (var letter in letters) hash = hash * 31 + letter;
            var found = Known[hash & 63];
            var same = found != null && found.Length == letters.Length;
            // A letter beyond ASCII is no byte.
            for (var i = 0; same && i < letters.Length; i++) same = found[i] == letters[i] && letters[i] < 128;
            return same ? found : Known[hash & 63] = Utf8.GetString(letters);
        }

        // Goes past a value, which it also makes if it is asked to, and throws where it is none.
        private object Read(bool make, int deeper)
        {
            var first = Next();
            if (first == '"') return Text(make);
            if (first == 't') return Word("true", True);
            if (first == 'f') return Word("false", False);
            if (first == 'n') return Word("null", null);
            if (first != '{' && first != '[') return Number(make);
            if (deeper == 0) throw Wrong($"it nests more than {Deepest} levels deep");
            var fields = make && first == '{' ? new Dictionary<string, object>() : null;
            var items = make && first == '[' ? new List<object>() : null;
            for (var more = Into(); more; more = More(first + 2))
            {
                var name = first == '{' ? Name(make) : null;
                var value = Read(make, deeper - 1);
                if (fields != null) fields[name] = value;
                items?.Add(value);
            }
            return (object)fields ?? items;
        }

        private object Word(string word, object means)
        {
            foreach (var letter in word)
                if (!Take(letter)) throw Wrong();
            return means;
        }

        /// <summary>The text that begins here; null unless it is to be made.</summary>
        public string Text(bool make = true)
        {
            StringBuilder text = null;
            Expect('"');
            var start = At;
            while (!Take('"'))
            {
                if (At == bytes.Length || bytes[At] < ' ') throw Wrong();
                var letters = bytes.Slice(start, At - start);
                At++;
                if (bytes[At - 1] != '\\') continue;
                var one = Escaped();
                var two = char.IsHighSurrogate(one) && Take('\\') ? Escaped() : '\0';
                if (char.IsSurrogate(one) && !char.IsLowSurrogate(two)) throw Wrong("half a character");
                if (!make) continue;
                text = (text ?? new StringBuilder()).Append(Utf8.GetString(letters)).Append(one);
                if (two != '\0') text.Append(two);
                start = At;
            }
            var rest = bytes.Slice(start, At - 1 - start);
            if (make) return text == null ? Kept(rest) : text.Append(Utf8.GetString(rest)).ToString();
            try { Utf8.GetCharCount(rest); }
            catch (ArgumentException) { throw Wrong("no UTF-8"); }
            return null;
        }

        private object Number(bool make)
        {
            var start = At;
            Take('-');
            var whole = Take('0') ? 1 : Digits();
            var after = Take('.') ? Digits() : 0;
            if (Take('e') || Take('E'))
            {
                if (!Take('+')) Take('-');
                after = Digits();
            }
            if (after == 0 && whole > MostDigits) throw Wrong($"{whole} digits are too many");
            var word = bytes.Slice(start, At - start);
            return !make ? null : after == 0 ? Whole(word) : (object)Real(word);
        }

        private int Digits()
        {
            var start = At;
            while (At < bytes.Length && bytes[At] >= '0' && bytes[At] <= '9') At++;
            return At > start ? At - start : throw Wrong();
        }

        // The byte that the next word begins with; -1 at the end.
        private int Next()
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
            if (Next() != letter) throw Wrong($"'{(char)letter}' is missing");
            At++;
        }

        // The character that an escape means, from behind its backslash on.
        private char Escaped()
        {
            for (var i = 0; i < Escapes.Length; i++)
                if (Take(Escapes[i])) return Meant[i];
            var digits = Take('u') ? bytes.Slice(At, Math.Min(4, bytes.Length - At)) : default;
            Utf8Parser.TryParse(digits, out ushort code, out var length, 'x');
            if (length < 4) throw Wrong();
            At += 4;
            return (char)code;
        }

        private MessageException Wrong(string what = "none of JSON's words") =>
            new MessageException("bad-json", $"the header is not JSON in UTF-8: {what} at byte {At}");
    }
}
