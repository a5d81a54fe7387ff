// What lies beside the scenes: assets, values as JSON, and events that the inspector wires.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using System.Text.RegularExpressions;

namespace UnityEngine
{
    /// <summary>What is in no scene: an asset, or a window of the editor.</summary>
    public class ScriptableObject : Object
    {
        public static T CreateInstance<T>() where T : ScriptableObject
        {
            MainThread.Only("CreateScriptableObjectInstanceFromType");
            var made = (T)Activator.CreateInstance(typeof(T));
            typeof(T).GetMethod("OnEnable", BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic)?.Invoke(made, null);
            return made;
        }
    }

    public sealed class Resources
    {
        /// <summary>By the path below a folder Resources, without the file's extension.</summary>
        internal static Dictionary<string, Object> Assets { get; } = new Dictionary<string, Object>();

        public static T Load<T>(string path) where T : Object
        {
            MainThread.Only(nameof(Load));
            return Assets.TryGetValue(path, out var asset) ? asset as T : null;
        }
    }

    /// <summary>Of texts alone: the lessons have no use for more.</summary>
    public static class JsonUtility
    {
        public static string ToJson(object obj) =>
            $"{{{string.Join(",", Texts(obj).Select(field => $"\"{field.Name}\":\"{Escaped((string)field.GetValue(obj))}\""))}}}";

        public static T FromJson<T>(string json)
        {
            var made = Activator.CreateInstance<T>();
            FromJsonOverwrite(json, made);
            return made;
        }

        public static void FromJsonOverwrite(string json, object objectToOverwrite)
        {
            foreach (Match pair in Regex.Matches(json, "\"(\\w+)\":\"((?:[^\"\\\\]|\\\\.)*)\""))
                foreach (var field in Texts(objectToOverwrite).Where(field => field.Name == pair.Groups[1].Value))
                    field.SetValue(objectToOverwrite, Regex.Replace(pair.Groups[2].Value, @"\\(.)", "$1"));
        }

        private static string Escaped(string text) => (text ?? "").Replace("\\", "\\\\").Replace("\"", "\\\"");

        private static IEnumerable<FieldInfo> Texts(object obj)
        {
            const BindingFlags own = BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic | BindingFlags.DeclaredOnly;
            for (var type = obj.GetType(); type != null && type != typeof(MonoBehaviour); type = type.BaseType)
                foreach (var field in type.GetFields(own))
                    if (field.FieldType == typeof(string) && (field.IsPublic || field.IsDefined(typeof(SerializeField)))) yield return field;
        }
    }
}

namespace UnityEngine.Events
{
    public delegate void UnityAction<T0>(T0 arg0);

    public abstract class UnityEventBase { }

    public class UnityEvent<T0> : UnityEventBase
    {
        private event UnityAction<T0> Calls;

        public void AddListener(UnityAction<T0> call) => Calls += call;

        public void Invoke(T0 arg0) => Calls?.Invoke(arg0);
    }
}
