// Unity's own JSON: the fields that the inspector would show, and nothing else.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using System.Reflection;
using System.Text.RegularExpressions;
using UnityPlayer;

namespace UnityEngine
{
    public static class JsonUtility
    {
        // So deep Unity looks into classes, which may hold one another.
        private const int Deepest = 10;
        public static string ToJson(object obj) => ToJson(obj, false);

        // As in Unity: a list, a text or a number that is in no class is nothing, without a word.
        public static string ToJson(object obj, bool prettyPrint)
        {
            if (obj == null) return "";
            if (IsEngines(obj)) throw new ArgumentException("JsonUtility.ToJson does not support engine types.");
            var end = prettyPrint ? "\n" : null;
            return Inspector.Item(obj.GetType()) != null || obj is string || obj.GetType().IsPrimitive
                ? "{}"
                : Written(obj, obj.GetType(), end);
        }

        public static T FromJson<T>(string json) => (T)FromJson(json, typeof(T));

        public static object FromJson(string json, Type type)
        {
            if (string.IsNullOrEmpty(json)) return null;
            if (type.IsAbstract || typeof(Object).IsAssignableFrom(type))
                throw new ArgumentException($"Cannot deserialize JSON to new instances of type '{type.Name}.'");
            var made = Activator.CreateInstance(type);
            Fill(made, Values(json));
            return made;
        }

        public static void FromJsonOverwrite(string json, object objectToOverwrite)
        {
            if (string.IsNullOrEmpty(json)) return;
            if (IsEngines(objectToOverwrite ?? throw new ArgumentNullException(nameof(objectToOverwrite))))
                throw new ArgumentException("Engine types cannot be overwritten from JSON outside of the Editor.");
            Fill(objectToOverwrite, Values(json));
        }

        private static bool IsEngines(object obj) =>
            obj is Object && !(obj is MonoBehaviour) && !(obj is ScriptableObject);

        private static Dictionary<string, object> Values(string json) =>
            Reader.Read(json) as Dictionary<string, object>
                ?? throw new ArgumentException("JSON must represent an object type.");

        // Each item on a line of its own begins with `end`, as do the brackets around them; null: all in one line.
        private static string Written(object value, Type type, string end, int depth = 0)
        {
            if (type == typeof(string)) return $"\"{Regex.Replace((string)value ?? "", "[\\p{Cc}\"\\\\]", Escaped)}\"";
            if (type == typeof(bool)) return (bool)value ? "true" : "false";
            if (type.IsEnum) return Convert.ToInt64(value).ToString(CultureInfo.InvariantCulture);
            if (type == typeof(float) || type == typeof(double))
                return Regex.Replace(((IFormattable)value).ToString("R", CultureInfo.InvariantCulture), "^-?\\d+$",
                    "$0.0");
            if (type.IsPrimitive) return ((IFormattable)value).ToString("D", CultureInfo.InvariantCulture);
            var next = end == null ? null : $"{end}    ";
            if (Inspector.Item(type) is Type item)
                return Brackets("[]", end,
                    ((IEnumerable)value ?? Array.Empty<object>()).Cast<object>()
                        .Select(each => Written(each, item, next, depth)));
            value ??= Activator.CreateInstance(type);
            var fields = depth < Deepest ? Fields(type) : new FieldInfo[0];
            var space = end == null ? "" : " ";
            return Brackets("{}", end, fields.Select(field =>
                $"\"{field.Name}\":{space}{Written(field.GetValue(value), field.FieldType, next, depth + 1)}"));
        }

        private static string Brackets(string pair, string end, IEnumerable<string> items) =>
            end == null || !items.Any()
                ? $"{pair[0]}{string.Join(",", items)}{pair[1]}"
                : $"{pair[0]}{end}    {string.Join($",{end}    ", items)}{end}{pair[1]}";

        private static string Escaped(Match sign) => sign.Value switch
        {
            "\"" => "\\\"",
            "\\" => "\\\\",
            "\n" => "\\n",
            _ => $"\\u{(int)sign.Value[0]:x4}",
        };

        private static void Fill(object target, Dictionary<string, object> values)
        {
            foreach (var field in Fields(target.GetType()))
                if (values.TryGetValue(field.Name, out var value) && value != null)
                    field.SetValue(target, As(value, field.FieldType, field.GetValue(target)));
        }

        private static object As(object value, Type type, object before)
        {
            if (type.IsEnum) return Enum.ToObject(type, value);
            if (type.IsPrimitive || type == typeof(string))
                return Convert.ChangeType(value, type, CultureInfo.InvariantCulture);
            if (Inspector.Item(type) is Type item)
            {
                var items = (List<object>)value;
                var array = Array.CreateInstance(item, items.Count);
                for (var i = 0; i < array.Length; i++) array.SetValue(As(items[i], item, null), i);
                return type.IsArray ? array : Activator.CreateInstance(type, array);
            }
            before ??= Activator.CreateInstance(type);
            Fill(before, (Dictionary<string, object>)value);
            return before;
        }

        // A component of one's own is written as well, and what it holds of Unity's only in Unity. A base class comes
        // first.
        private static IEnumerable<FieldInfo> Fields(Type type) =>
            !Inspector.IsPlain(type) && !typeof(Object).IsAssignableFrom(type) ? new FieldInfo[0]
            : Inspector.Fields(type)
                .Where(field => Inspector.IsPlain(Inspector.Item(field.FieldType) ?? field.FieldType))
                .GroupBy(field => field.DeclaringType).Reverse().SelectMany(fields => fields);

        /// <summary>Objects as dictionaries, arrays as lists, numbers as long or double.</summary>
        private sealed class Reader
        {
            private readonly Queue<string> tokens;

            private Reader(string json)
            {
                var found = Regex.Matches(json ?? "",
                    "\\G\\s*([{}\\[\\]:,]|\"(?:[^\"\\\\]|\\\\.)*\"|-?\\d[-+.\\w]*|true|false|null)\\s*");
                if (found.Sum(token => token.Length) != (json ?? "").Length) throw Wrong();
                tokens = new Queue<string>(found.Select(token => token.Groups[1].Value));
            }

            public static object Read(string json)
            {
                var reader = new Reader(json);
                var value = reader.Value();
                return reader.tokens.Count == 0 ? value : throw Wrong();
            }

            public static ArgumentException Wrong() => new ArgumentException("JSON parse error: Invalid value.");
            private string Next() => tokens.TryDequeue(out var token) ? token : throw Wrong();

            private object Value()
            {
                var token = Next();
                if (token == "[") return All("]", Value);
                if (token == "{")
                    return All("}", () => (name: Text(Next()), value: Next() == ":" ? Value() : throw Wrong()))
                        .GroupBy(pair => pair.name).ToDictionary(pairs => pairs.Key, pairs => pairs.Last().value);
                if (token == "null") return null;
                if (token[0] == '"') return Text(token);
                if (bool.TryParse(token, out var yes)) return yes;
                if (long.TryParse(token, NumberStyles.AllowLeadingSign, CultureInfo.InvariantCulture, out var whole))
                    return whole;
                return double.TryParse(token, NumberStyles.Float, CultureInfo.InvariantCulture, out var number)
                    ? number
                    : throw Wrong();
            }

            private List<T> All<T>(string end, Func<T> next)
            {
                var all = new List<T>();
                if (tokens.TryPeek(out var first) && first == end) tokens.Dequeue();
                else
                    for (var sign = ","; sign != end; sign = Next())
                        all.Add(sign == "," ? next() : throw Wrong());
                return all;
            }

            private static string Text(string token) =>
                token[0] != '"'
                    ? throw Wrong()
                    : Regex.Replace(token.Substring(1, token.Length - 2), @"\\(u....|.)", sign => sign.Value[1] switch
            {
                'u' => ((char)Convert.ToInt32(sign.Value.Substring(2), 16)).ToString(),
                'n' => "\n",
                'r' => "\r",
                't' => "\t",
                'b' => "\b",
                'f' => "\f",
                var other => other.ToString(),
            });
        }
    }
}
