// Texts for a log: a peer's message, and the reason of an end.
using System;
using System.Globalization;
using System.IO;
using System.Text;

namespace NetMQExample
{
    /// <summary>Texts for a log.</summary>
    public static class LogText
    {
        /// <summary>The text of an exception on the network thread. Those of this kit name cause and cure in one
        /// line; of all others the type and the stack are needed too, above all in a build on a device.</summary>
        /// <returns>Its message, or everything that is known of it.</returns>
        public static string Why(Exception e) =>
            e is TimeoutException || e is ArgumentException || e is IOException || e is OperationCanceledException
                ? e.Message : e.ToString();

        /// <summary>Makes a peer's text fit for one line: no control characters, cut to a readable length.</summary>
        /// <returns>At most so many characters and an ellipsis; a question mark for each one that cannot be
        /// shown.</returns>
        public static string Printable(string text, int most = 200)
        {
            var line = new StringBuilder();
            for (int at = 0, length = 0; text != null && at < text.Length; length++)
            {
                if (length == most) return line.Append('…').ToString();
                // A character beyond the first 65,536, such as an emoji, takes two chars.
                var width = char.IsSurrogatePair(text, at) ? 2 : 1;
                var kind = CharUnicodeInfo.GetUnicodeCategory(text, at);
                // Spaces, separators, controls, formats, halves of a pair and private use stand together in the enum.
                var hidden = kind >= UnicodeCategory.SpaceSeparator && kind <= UnicodeCategory.PrivateUse
                    || kind == UnicodeCategory.OtherNotAssigned;
                if (hidden && text[at] != ' ') line.Append('?');
                else line.Append(text, at, width);
                at += width;
            }
            return line.ToString();
        }
    }
}
