// Reads components from the text of a scene, as Unity does by the names of fields, and prints what they then have:
//
//     … play.dll mlscene scene.unity        each component is "--- Name" and lines such as "  m_RayLength: 20"
using System;
using System.Collections;
using System.Collections.Generic;
using System.Globalization;
using System.IO;
using System.Linq;
using System.Reflection;
using NetMQExample.MLAgents.Policies;
using UnityEngine;
using UnityEngine.Serialization;
using UnityPlayer;

namespace NetMQExample.PlayTest
{
    internal static class MlScene
    {
        private const BindingFlags Any = BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic;

        public static int Run(string path)
        {
            var player = new Player(typeof(NetMQLifetime).Assembly);
            player.Begin(() => Read(File.ReadAllLines(path)));
            return 0;
        }

        private static void Read(string[] lines)
        {
            for (var at = 0; at < lines.Length;)
            {
                var type = typeof(BehaviorParameters).Assembly.GetTypes().Single(
                    one => one.Name == lines[at].Substring(4) && one.Namespace.StartsWith("NetMQExample.MLAgents"));
                var thing = new GameObject(type.Name).AddComponent(type);
                var begin = ++at;
                while (at < lines.Length && !lines[at].StartsWith("---")) at++;
                Fill(thing, lines.Skip(begin).Take(at - begin).ToList(), type.Name);
                Show(thing, type.Name);
            }
        }

        private static void Fill(object thing, List<string> lines, string place)
        {
            for (var i = 0; i < lines.Count; i++)
            {
                var words = lines[i].Trim().Split(new[] { ": " }, 2, StringSplitOptions.None);
                var depth = lines[i].TakeWhile(letter => letter == ' ').Count();
                var inner = lines.Skip(i + 1)
                    .TakeWhile(line => line.TakeWhile(letter => letter == ' ').Count() > depth || line.Trim()[0] == '-')
                    .ToList();
                var name = words[0].TrimEnd(':');
                i += inner.Count;
                var field = Inspector.Fields(thing.GetType()).FirstOrDefault(one => one.Name == name
                    || one.GetCustomAttributes<FormerlySerializedAsAttribute>().Any(old => old.oldName == name));
                if (field == null) Console.WriteLine($"{place} has no {name}");
                else if (words.Length > 1) field.SetValue(thing, Value(field.FieldType, words[1]));
                else if (field.FieldType == typeof(LayerMask))
                    field.SetValue(thing, (LayerMask)(int)uint.Parse(inner[1].Split(' ').Last()));
                else if (field.FieldType == typeof(string)) field.SetValue(thing, "");
                else if (Item(field.FieldType) is Type item) field.SetValue(thing, List(field.FieldType, item, inner));
                else
                {
                    var part = field.GetValue(thing);
                    Fill(part, inner, $"{place}.{name}");
                    field.SetValue(thing, part);
                }
            }
            (thing as ISerializationCallbackReceiver)?.OnAfterDeserialize();
        }

        private static Type Item(Type type) => type.IsArray ? type.GetElementType()
            : type.IsGenericType ? type.GetGenericArguments()[0] : null;

        private static object List(Type type, Type item, List<string> lines)
        {
            var items = Array.CreateInstance(item, lines.Count);
            for (var i = 0; i < lines.Count; i++) items.SetValue(Value(item, lines[i].Trim(' ', '-')), i);
            return type.IsArray ? items : Activator.CreateInstance(type, items);
        }

        private static object Value(Type type, string text)
        {
            // An array of numbers stands as their bytes, the lowest first.
            if (type == typeof(int[]))
                return Enumerable.Range(0, text.Length == 2 ? 0 : text.Length / 8).Select(i => BitConverter.ToInt32(
                    Enumerable.Range(0, 4).Select(k => Convert.ToByte(text.Substring((8 * i) + (2 * k), 2), 16))
                        .ToArray(), 0)).ToArray();
            if (text == "[]") return List(type, Item(type), new List<string>());
            if (type == typeof(Color))
            {
                var parts = text.Trim('{', '}').Split(',')
                    .Select(part => float.Parse(part.Split(':')[1], CultureInfo.InvariantCulture)).ToArray();
                return new Color(parts[0], parts[1], parts[2], parts[3]);
            }
            if (type.IsEnum) return Enum.ToObject(type, int.Parse(text, CultureInfo.InvariantCulture));
            if (type == typeof(bool)) return text != "0";
            return text.StartsWith("{fileID") ? null : Convert.ChangeType(text, type, CultureInfo.InvariantCulture);
        }

        private static void Show(object thing, string place)
        {
            foreach (var property in thing.GetType().GetProperties(Any).Where(IsOurs))
                Print($"{place}.{property.Name}", property.GetValue(thing));
            foreach (var field in thing.GetType().GetFields().Where(IsOurs))
                Print($"{place}.{field.Name}", field.GetValue(thing));
        }

        private static bool IsOurs(MemberInfo member) => member.DeclaringType.Namespace.StartsWith("NetMQExample");

        private static void Print(string name, object value)
        {
            if (value is BrainParameters || value is MLAgents.Actuators.ActionSpec) Show(value, name);
            else if (value is LayerMask mask) Console.WriteLine($"{name}: {mask.value}");
            else if (value is IEnumerable many && !(value is string))
                Console.WriteLine($"{name}: {string.Join(" ", many.Cast<object>())}");
            else Console.WriteLine(FormattableString.Invariant($"{name}: {value}"));
        }
    }
}
