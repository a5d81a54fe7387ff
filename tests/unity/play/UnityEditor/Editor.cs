// The editor as a whole: windows, menus, what it remembers, and its end.
using System;
using System.Collections.Generic;
using UnityEngine;

namespace UnityEditor
{
    [AttributeUsage(AttributeTargets.Method, AllowMultiple = true)]
    public sealed class MenuItem : Attribute
    {
        public string menuItem;

        public MenuItem(string itemName, bool isValidateFunction, int priority) => menuItem = itemName;
    }

    [AttributeUsage(AttributeTargets.Method)]
    public class InitializeOnLoadMethodAttribute : Attribute { }

    public class EditorWindow : ScriptableObject
    {
        internal static List<EditorWindow> Opened { get; } = new List<EditorWindow>();

        public static T GetWindow<T>(string title) where T : EditorWindow
        {
            if (Opened.Find(window => window is T) is T there) return there;
            var made = CreateInstance<T>();
            Opened.Add(made);
            return made;
        }

        public void Repaint() { }
    }

    /// <summary>Settings that outlive the editor.</summary>
    public sealed class EditorPrefs
    {
        private static readonly Dictionary<string, string> Kept = new Dictionary<string, string>();

        public static void SetString(string key, string value) => Kept[key] = value;

        public static string GetString(string key, string defaultValue) =>
            Kept.TryGetValue(key, out var value) ? value : defaultValue;
    }

    public class EditorUtility
    {
        /// <summary>The user's choice in a dialogue.</summary>
        internal static string Chosen { get; set; } = "";

        /// <summary>The objects in Assets, and not in the scene.</summary>
        internal static HashSet<UnityEngine.Object> Assets { get; } = new HashSet<UnityEngine.Object>();
        public static bool IsPersistent(UnityEngine.Object target) => Assets.Contains(target);
        public static string OpenFolderPanel(string title, string folder, string defaultName) => Chosen;
    }

    public sealed class EditorGUIUtility : GUIUtility
    {
        public static new string systemCopyBuffer
        {
            get => GUIUtility.systemCopyBuffer;
            set => GUIUtility.systemCopyBuffer = value;
        }
    }
}

namespace UnityEngine
{
    public class GUIUtility
    {
        public static string systemCopyBuffer { get; set; } = "";
    }
}
