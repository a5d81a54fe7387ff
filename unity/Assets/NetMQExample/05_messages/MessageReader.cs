// Reads JSON in UTF-8 where it lies, word by word: it looks up no class by its name, so a message can make nothing but
// texts, numbers, true, false, lists and dictionaries, and IL2CPP has nothing to strip.
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
        private readonly MessageStore store;
        private int at;

        private MessageReader(ReadOnlySpan<byte> bytes, MessageStore store)
        {
            this.bytes = MemoryMarshal.CreateSpan(ref MemoryMarshal.GetReference(bytes), bytes.Length);
            this.store = store;
            at = 0;
        }

        /// <summary>Makes of a JSON text what it means: whole numbers are long, other numbers double, lists
        /// List&lt;object&gt;, objects Dictionary. Of two fields with one name the last counts.</summary>
        /// <param name="store">Where these come from.</param>
        /// <exception cref="MessageException">It is none, or deeper than any header.</exception>
        public static object Read(ReadOnlySpan<byte> bytes, MessageStore store)
        {
            var json = new MessageReader(bytes, store);
            try
            {
                var value = json.Value(Deepest);
                return json.Next() < 0 ? value : throw json.Wrong("more follows it");
            }
            catch (ArgumentException) { throw json.Wrong("no UTF-8"); }
        }

        private object Value(int deeper)
        {
            var first = Next();
            if (first == '"') return Text();
            if (first == 't') return Word("true", True);
            if (first == 'f') return Word("false", False);
            if (first == 'n') return Word("null", null);
            if (first != '{' && first != '[') return Number();
            if (deeper == 0) throw Wrong($"it nests more than {Deepest} levels deep");
            at++;
            return first == '{' ? (object)Fields(deeper - 1) : Items(deeper - 1);
        }

        private Dictionary<string, object> Fields(int deeper)
        {
            var fields = store.Object();
            for (var more = Next() != '}' || !Take('}'); more; more = More('}'))
            {
                var name = Text();
                Expect(':');
                fields[name] = Value(deeper);
            }
            return fields;
        }

        private List<object> Items(int deeper)
        {
            var items = store.List();
            for (var more = Next() != ']' || !Take(']'); more; more = More(']')) items.Add(Value(deeper));
            return items;
        }

        private bool More(int close)
        {
            Next();
            if (Take(',')) return true;
            Expect(close);
            return false;
        }

        private object Word(string word, object means)
        {
            foreach (var letter in word)
                if (!Take(letter)) throw Wrong();
            return means;
        }

        private string Text()
        {
            StringBuilder text = null;
            Expect('"');
            var start = at;
            while (!Take('"'))
            {
                if (at == bytes.Length || bytes[at] < ' ') throw Wrong();
                if (bytes[at++] != '\\') continue;
                var letters = bytes.Slice(start, at - 1 - start);
                var one = Escaped();
                var two = char.IsHighSurrogate(one) && Take('\\') ? Escaped() : '\0';
                if (char.IsSurrogate(one) && !char.IsLowSurrogate(two)) throw Wrong("half a character");
                text = (text ?? new StringBuilder()).Append(Utf8.GetString(letters)).Append(one);
                if (two != '\0') text.Append(two);
                start = at;
            }
            var rest = bytes.Slice(start, at - 1 - start);
            return text == null ? Kept(rest) : text.Append(Utf8.GetString(rest)).ToString();
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

        private object Number()
        {
            var start = at;
            Take('-');
            var digits = Take('0') ? 1 : Digits();
            var after = Take('.') ? Digits() : 0;
            if (Take('e') || Take('E'))
            {
                if (!Take('+')) Take('-');
                after = Digits();
            }
            if (after == 0 && digits > MostDigits) throw Wrong($"{digits} digits are too many");
            var word = bytes.Slice(start, at - start);
            if (after > 0) return store.Number(Real(word));
            // One that no long can hold is exact nowhere: it is a long that nobody takes.
            if (!Utf8Parser.TryParse(word, out long whole, out _)) whole = long.MaxValue;
            return store.Number(whole);
        }

        private static double Real(Span<byte> word)
        {
            Span<char> letters = word.Length <= 64 ? stackalloc char[word.Length] : new char[word.Length];
            for (var i = 0; i < word.Length; i++) letters[i] = (char)word[i];
            // Too large a number is infinite to .NET, and none at all to Mono.
            return double.TryParse(letters, NumberStyles.Float, CultureInfo.InvariantCulture, out var number)
                ? number : double.PositiveInfinity;
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
