// Reads JSON in UTF-8 where it lies, forwards and word by word: it looks up no class by its name, so a message can make
// nothing but texts, numbers, true, false, lists and dictionaries, and IL2CPP has nothing to strip.
//
// Two languages must agree on what is a message, so it takes what RFC 8259 has, and no more: no comments, no NaN, no
// comma too many, and no \ud800, which is half a character.
using System;
using System.Buffers.Text;
using System.Collections.Generic;
using System.Globalization;
using System.Runtime.InteropServices;
using System.Text;

namespace NetMQExample
{
    /// <summary>Whole numbers are long, other numbers double, lists List&lt;object&gt;, objects Dictionary. Where it is
    /// no JSON, all of it throws a MessageException.</summary>
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
        private readonly MessageNumbers numbers;
        private int at;

        /// <summary>Begins at a JSON text; its numbers go into boxes of their own, or into these.</summary>
        public MessageReader(ReadOnlySpan<byte> bytes, MessageNumbers numbers = null)
        {
            this.bytes = MemoryMarshal.CreateSpan(ref MemoryMarshal.GetReference(bytes), bytes.Length);
            this.numbers = numbers;
            at = 0;
        }

        /// <summary>What a whole JSON text means.</summary>
        public static object Read(ReadOnlySpan<byte> bytes)
        {
            var json = new MessageReader(bytes);
            var value = json.Value();
            json.End();
            return value;
        }

        /// <summary>Finds fields of the object that begins here, and goes behind it. Of two with one name the last
        /// counts.</summary>
        /// <param name="names">The fields.</param>
        /// <param name="places">Gets where the value of each begins; 0: nowhere, -1: here is no object.</param>
        public void Find(string[] names, int[] places)
        {
            var isObject = Next() == '{';
            Array.Fill(places, isObject ? 0 : -1);
            if (!isObject) Skip();
            for (var more = isObject && Into(); more; more = More('}'))
            {
                var field = Array.IndexOf(names, Name());
                if (field >= 0) places[field] = at;
                Read(false, Deepest - 1);
            }
        }

        /// <summary>Goes to the value of a field.</summary>
        /// <param name="place">Where it was found.</param>
        /// <param name="name">The field.</param>
        /// <param name="what">Its kind: "text", "whole number", "list" or "dict".</param>
        public void Go(int place, string name, string what)
        {
            if (place < 0) throw new MessageException("wrong-type", $"expected an object with '{name}'");
            if (place == 0) throw new MessageException("missing-field", $"there is no '{name}'");
            at = place;
            if (Kind() != what) throw new MessageException("wrong-type", $"'{name}' must be a {what}");
        }

        /// <summary>Refuses what follows.</summary>
        public void End()
        {
            if (Next() >= 0) throw Wrong("more follows it");
        }

        /// <summary>Goes into the list, or the object, that begins here.</summary>
        /// <returns>Whether there is anything in it; then <see cref="More"/> goes on.</returns>
        public bool Into()
        {
            var close = Next() + 2;
            at++;
            if (Next() != close) return true;
            at++;
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

        /// <summary>How many items the list has that begins here.</summary>
        public int Count()
        {
            var (start, count) = (at, 0);
            for (var more = Into(); more; more = More(']'), count++) Skip();
            at = start;
            return count;
        }

        /// <summary>The name of a field, whose value follows.</summary>
        public string Name() => Name(true);

        /// <summary>The text that begins here.</summary>
        public string Text() => Text(true);

        /// <summary>A whole number; -1 is any other value as well.</summary>
        public long Whole()
        {
            var isWhole = Kind() == "whole number";
            var word = Skip();
            return isWhole ? Whole(word) : -1;
        }

        /// <summary>Any value.</summary>
        public object Value() => Read(true, Deepest);

        private Span<byte> Skip()
        {
            Next();
            var start = at;
            Read(false, Deepest);
            return bytes.Slice(start, at - start);
        }

        private string Kind()
        {
            var first = Next();
            var start = at;
            var word = Skip();
            at = start;
            return first == '"' ? "text" : first == '[' ? "list" : first == '{' ? "dict"
                : first <= '9' && word.IndexOfAny((byte)'.', (byte)'e', (byte)'E') < 0 ? "whole number" : "";
        }

        // One that no long can hold is exact nowhere: it is a long that nobody takes.
        private static long Whole(Span<byte> word) =>
            Utf8Parser.TryParse(word, out long number, out _) ? number : long.MaxValue;

        private static double Real(Span<byte> word)
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

        // Goes past a value, which it also makes if it is asked to.
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

        private string Name(bool make)
        {
            var name = Text(make);
            Expect(':');
            return name;
        }

        // Null unless it is to be made.
        private string Text(bool make)
        {
            StringBuilder text = null;
            Expect('"');
            var start = at;
            try
            {
                while (!Take('"'))
                {
                    if (at == bytes.Length || bytes[at] < ' ') throw Wrong();
                    if (bytes[at++] != '\\') continue;
                    var letters = bytes.Slice(start, at - 1 - start);
                    var one = Escaped();
                    var two = char.IsHighSurrogate(one) && Take('\\') ? Escaped() : '\0';
                    if (char.IsSurrogate(one) && !char.IsLowSurrogate(two)) throw Wrong("half a character");
                    if (!make) continue;
                    text = (text ?? new StringBuilder()).Append(Utf8.GetString(letters)).Append(one);
                    if (two != '\0') text.Append(two);
                    start = at;
                }
                var rest = bytes.Slice(start, at - 1 - start);
                if (make) return text == null ? Kept(rest) : text.Append(Utf8.GetString(rest)).ToString();
                Utf8.GetCharCount(rest);
                return null;
            }
            catch (ArgumentException) { throw Wrong("no UTF-8"); }
        }

        private object Number(bool make)
        {
            var start = at;
            Take('-');
            var whole = Take('0') ? 1 : Digits();
            var after = Take('.') ? Digits() : 0;
            if (Take('e') || Take('E'))
            {
                if (!Take('+')) Take('-');
                after = Digits();
            }
            if (after == 0 && whole > MostDigits) throw Wrong($"{whole} digits are too many");
            var word = bytes.Slice(start, at - start);
            if (!make) return null;
            if (after == 0) return numbers?.Put(Whole(word)) ?? Whole(word);
            return numbers?.Put(Real(word)) ?? Real(word);
        }

        private int Digits()
        {
            var start = at;
            while (at < bytes.Length && bytes[at] >= '0' && bytes[at] <= '9') at++;
            return at > start ? at - start : throw Wrong();
        }

        // The byte that the next word begins with; -1 at the end.
        private int Next()
        {
            for (; at < bytes.Length; at++)
            {
                var letter = bytes[at];
                if (letter != ' ' && letter != '\n' && letter != '\r' && letter != '\t') return letter;
            }
            return -1;
        }

        // Whether this byte comes now, which is passed then.
        private bool Take(int letter)
        {
            if (at == bytes.Length || bytes[at] != letter) return false;
            at++;
            return true;
        }

        private void Expect(int letter)
        {
            if (Next() != letter) throw Wrong($"'{(char)letter}' is missing");
            at++;
        }

        // The character that an escape means, from behind its backslash on.
        private char Escaped()
        {
            for (var i = 0; i < Escapes.Length; i++)
                if (Take(Escapes[i])) return Meant[i];
            var digits = Take('u') ? bytes.Slice(at, Math.Min(4, bytes.Length - at)) : default;
            Utf8Parser.TryParse(digits, out ushort code, out var length, 'x');
            if (length < 4) throw Wrong();
            at += 4;
            return (char)code;
        }

        private MessageException Wrong(string what = "none of JSON's words") =>
            new MessageException("bad-json", $"the header is not JSON in UTF-8: {what} at byte {at}");
    }
}
