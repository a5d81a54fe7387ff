// The header of a message as JSON, by Newtonsoft.Json, word by word: it looks up no class by its name, so a message can
// make nothing but texts, numbers, true, false, lists and dictionaries, and IL2CPP has nothing to strip.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Globalization;
using System.IO;
using System.Numerics;
using System.Text;
using System.Text.RegularExpressions;
using Newtonsoft.Json;

namespace NetMQExample
{
    /// <summary>Whole numbers are long, other numbers double, lists List&lt;object&gt;, objects Dictionary.</summary>
    internal static class MessageJson
    {
        private static readonly UTF8Encoding Utf8 = new UTF8Encoding(false, true);
        // Newtonsoft.Json reads more than JSON: comments, 'single quotes', NaN, 010 as 8, a comma too many. Two
        // languages must agree on what is a message, so a header has to consist of JSON's own words. And \ud800 is half
        // a character, which Newtonsoft.Json would replace.
        private static readonly Regex Words = new Regex(
            @"^(?>(?:[ \t\n\r}\]]+|[{[:](?![ \t\n\r]*,)|,(?![ \t\n\r]*[,}\]])" +
            @"|""[^""\\\x00-\x1f]*(?:\\(?:[""\\/bfnrt]|u(?![dD][89a-fA-F])[0-9a-fA-F]{4}" +
            @"|u[dD][89abAB][0-9a-fA-F]{2}\\u[dD][c-fC-F][0-9a-fA-F]{2})[^""\\\x00-\x1f]*)*""" +
            @"|-?(?:0|[1-9][0-9]*)(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?(?![\w.])|true|false|null)*)\z",
            RegexOptions.CultureInvariant);

        /// <summary>Reads a whole JSON text.</summary>
        /// <exception cref="MessageException">It is none, or deeper than any header.</exception>
        public static object Read(ReadOnlySpan<byte> bytes)
        {
            try
            {
                var text = Utf8.GetString(bytes);
                if (!Words.IsMatch(text)) throw new JsonReaderException("it has a word that is none of JSON's");
                using var json = new JsonTextReader(new StringReader(text));
                json.MaxDepth = 64;
                json.DateParseHandling = DateParseHandling.None;
                Next(json);
                var value = Value(json);
                // Throws if more follows.
                json.Read();
                return value;
            }
            catch (Exception e) when (e is JsonException || e is ArgumentException)
            {
                throw new MessageException("bad-json", $"the header is not JSON in UTF-8: {e.Message}");
            }
        }

        /// <summary>Writes JSON in ASCII: letters beyond it become \u1234, so that no encoding on the way can spoil
        /// them.</summary>
        public static string Write(object value)
        {
            var text = new StringWriter(CultureInfo.InvariantCulture);
            using (var json = new JsonTextWriter(text) { StringEscapeHandling = StringEscapeHandling.EscapeNonAscii })
                Write(json, value);
            // As Python writes it.
            return text.ToString().Replace("\x7f", "\\u007f");
        }

        /// <summary>A text as it stands in JSON.</summary>
        public static string Quoted(string text) =>
            JsonConvert.ToString(text, '"', StringEscapeHandling.EscapeNonAscii).Replace("\x7f", "\\u007f");

        /// <summary>A peer's words for an error's text: ASCII without control characters, and not long.</summary>
        public static string Shown(string word) => JsonConvert.ToString(
            word.Substring(0, Math.Min(word.Length, 40)), '\'', StringEscapeHandling.EscapeNonAscii);

        private static JsonToken Next(JsonReader json) =>
            json.Read() ? json.TokenType : throw new JsonReaderException("it ends too early");

        private static object Value(JsonReader json)
        {
            if (json.TokenType == JsonToken.StartObject)
            {
                var fields = new Dictionary<string, object>();
                while (Next(json) != JsonToken.EndObject)
                {
                    var name = (string)json.Value;
                    Next(json);
                    fields[name] = Value(json);
                }
                return fields;
            }
            // A number that no long can hold is exact nowhere, and Message refuses this one as well.
            if (json.TokenType != JsonToken.StartArray) return json.Value is BigInteger ? long.MaxValue : json.Value;
            var items = new List<object>();
            while (Next(json) != JsonToken.EndArray) items.Add(Value(json));
            return items;
        }

        private static void Write(JsonWriter json, object value)
        {
            if (value is Dictionary<string, object> fields)
            {
                json.WriteStartObject();
                foreach (var field in fields)
                {
                    json.WritePropertyName(field.Key);
                    Write(json, field.Value);
                }
                json.WriteEndObject();
            }
            else if (value is IEnumerable items && !(value is string))
            {
                json.WriteStartArray();
                foreach (var item in items) Write(json, item);
                json.WriteEndArray();
            }
            else json.WriteValue(value);
        }
    }
}
