// A game's memory; here it lasts until the process ends.
using System.Collections.Generic;

namespace UnityEngine
{
    public class PlayerPrefs
    {
        private static readonly Dictionary<string, object> Values = new Dictionary<string, object>();
        public static void SetInt(string key, int value) => Values[key] = value;
        public static void SetFloat(string key, float value) => Values[key] = value;
        public static void SetString(string key, string value) => Values[key] = value;
        public static int GetInt(string key) => GetInt(key, 0);
        public static int GetInt(string key, int defaultValue) => Get(key, defaultValue);
        public static float GetFloat(string key) => GetFloat(key, 0);
        public static float GetFloat(string key, float defaultValue) => Get(key, defaultValue);
        public static string GetString(string key) => GetString(key, "");
        public static string GetString(string key, string defaultValue) => Get(key, defaultValue);
        public static bool HasKey(string key) => Values.ContainsKey(key);
        public static void DeleteKey(string key) => Values.Remove(key);
        public static void DeleteAll() => Values.Clear();
        public static void Save() { }
        // A value that was set as another type is not there.
        private static T Get<T>(string key, T otherwise) =>
            Values.TryGetValue(key, out var value) && value is T found ? found : otherwise;
    }
}
