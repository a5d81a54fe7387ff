// Text from the other side: read as JSON that may be anything, and shown in one line of a log.
using System;
using System.Globalization;
using System.IO;
using System.Text;
using Newtonsoft.Json;
using Newtonsoft.Json.Linq;

namespace NetMQExample
{
    /// <summary>Texts that a stranger may have written.</summary>
    public static class WebText
    {
        public const string NoGateway = "what answers there is no gateway";

        // As Require's, which a WebGL build does not have.
        internal static string Given(string name, string value) =>
            value ?? throw new ArgumentNullException(null, $"{name} must not be null");

        /// <summary>Reads JSON.</summary>
        /// <returns>A list, or an object; one that says so as <c>error</c> if it is neither.</returns>
        public static JToken Parse(string text)
        {
            try
            {
                // Otherwise a text that looks like a date becomes one, and another text when it is written again.
                using var reader = new JsonTextReader(new StringReader(text));
                reader.DateParseHandling = DateParseHandling.None;
                if (JToken.ReadFrom(reader) is JContainer found) return found;
            }
            catch (JsonException) { /* The same as a lone number. */ }
            return new JObject { ["error"] = NoGateway };
        }

        /// <summary>As LogText's, which a WebGL build does not have: no control characters, and not too long.</summary>
        /// <returns>At most 200 characters and an ellipsis.</returns>
        public static string Printable(string text)
        {
            var line = new StringBuilder();
            var at = 0;
            var width = 0;
            for (var length = 0; at < text.Length; length++, at += width)
            {
                if (length == 200) return line.Append('…').ToString();
                width = char.IsSurrogatePair(text, at) ? 2 : 1;
                var kind = CharUnicodeInfo.GetUnicodeCategory(text, at);
                // Spaces, separators, controls, formats, halves of a pair and private use stand together in the enum.
                var hidden = kind >= UnicodeCategory.SpaceSeparator && kind <= UnicodeCategory.PrivateUse;
                if ((hidden && text[at] != ' ') || kind == UnicodeCategory.OtherNotAssigned) line.Append('?');
                else line.Append(text, at, width);
            }
            return line.ToString();
        }
    }
}
