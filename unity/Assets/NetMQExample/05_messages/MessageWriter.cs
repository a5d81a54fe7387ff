// Writes JSON in ASCII into a buffer that is used again: letters beyond it become \u1234, so that no encoding on the
// way can spoil them.
using System;
using System.Buffers.Text;
using System.Globalization;
using System.Text;

namespace NetMQExample
{
    /// <summary>What is written is right if it is called in the right order.</summary>
    internal sealed class MessageWriter
    {
        private const string Escapes = "\\bfnrt", Meant = "\\\b\f\n\r\t";
        private byte[] bytes = new byte[512];
        private int count;

        /// <summary>All since <see cref="Begin"/>; valid until that.</summary>
        public ReadOnlyMemory<byte> Written => new ReadOnlyMemory<byte>(bytes, 0, count);

        /// <summary>A text as it stands in JSON.</summary>
        public static string Quoted(string text) => new MessageWriter().Text(text).ToString();

        /// <summary>A peer's words for an error's text: ASCII without control characters, and not long.</summary>
        public static string Shown(string word) =>
            new MessageWriter().Text(word.Substring(0, Math.Min(word.Length, 40)), '\'').ToString();

        public MessageWriter Begin()
        {
            count = 0;
            return this;
        }

        /// <summary>Brackets, commas and names, as they are.</summary>
        public MessageWriter Add(string ascii)
        {
            count += Encoding.ASCII.GetBytes(ascii, Room(ascii.Length));
            return this;
        }

        /// <summary>A comma, but for the first item.</summary>
        public MessageWriter Comma() => bytes[count - 1] == '{' || bytes[count - 1] == '[' ? this : Add(',');

        public MessageWriter Text(string text, char quote = '"')
        {
            Add(quote);
            for (var i = 0; i < text.Length; i++)
            {
                var letter = text[i];
                var plain = letter >= ' ' && letter < '\x7f' && letter != '\\';
                var escape = plain ? -1 : Meant.IndexOf(letter);
                if (letter == quote) Add('\\').Add(letter);
                else if (plain) Add(letter);
                else if (escape >= 0) Add('\\').Add(Escapes[escape]);
                else
                {
                    if (quote == '"' && char.IsSurrogate(letter) && !IsWhole(text, i))
                        throw new MessageException("bad-json", "a text has half a character: where was it cut?");
                    Add("\\u");
                    for (var shift = 12; shift >= 0; shift -= 4) Add("0123456789abcdef"[(letter >> shift) & 15]);
                }
            }
            return Add(quote);
        }

        public MessageWriter Value(object value) => value switch
        {
            string text => Text(text),
            bool yes => Add(yes ? "true" : "false"),
            int whole => Whole(whole),
            long whole => Whole(whole),
            MessageNumber again => again.IsWhole ? Whole((long)again.Real) : Real(again.Real),
            float real => Digits(real.ToString("R", CultureInfo.InvariantCulture).ToCharArray()),
            _ => Real((double)value),
        };

        public MessageWriter Whole(long number)
        {
            Utf8Formatter.TryFormat(number, Room(20), out var length);
            count += length;
            return this;
        }

        public MessageWriter Real(double number)
        {
            Span<char> digits = stackalloc char[32];
            number.TryFormat(digits, out var length, "R", CultureInfo.InvariantCulture);
            return Digits(digits.Slice(0, length));
        }

        public override string ToString() => Encoding.ASCII.GetString(bytes, 0, count);

        private static bool IsWhole(string text, int at) =>
            char.IsSurrogatePair(text, char.IsLowSurrogate(text[at]) && at > 0 ? at - 1 : at);

        private MessageWriter Digits(Span<char> digits)
        {
            foreach (var digit in digits) Add(digit);
            // So that a reader makes a number of the same kind of it.
            return digits.IndexOfAny('.', 'E') < 0 ? Add(".0") : this;
        }

        private MessageWriter Add(char letter)
        {
            if (count == bytes.Length) Room(1);
            bytes[count++] = (byte)letter;
            return this;
        }

        private Span<byte> Room(int length)
        {
            if (bytes.Length - count < length) Array.Resize(ref bytes, 2 * bytes.Length + length);
            return bytes.AsSpan(count);
        }
    }
}
