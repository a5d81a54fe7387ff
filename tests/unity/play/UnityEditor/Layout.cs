// A window's drawing is kept as lines of text. A test presses a button, or types, before it is drawn.
using System;
using System.Collections.Generic;
using UnityEngine;

namespace UnityEditor
{
    internal static class Drawing
    {
        public static List<string> Lines { get; } = new List<string>();

        /// <summary>The button that is pressed.</summary>
        public static string Pressed { get; set; } = "";

        /// <summary>What is typed or chosen, by the label.</summary>
        public static Dictionary<string, string> Typed { get; } = new Dictionary<string, string>();

        /// <summary>In a window buttons are drawn as well.</summary>
        public static bool Button(string text)
        {
            Lines.Add($"[{text}]");
            return text == Pressed;
        }

        public static string Field(string label, string text)
        {
            if (Typed.TryGetValue(label, out var typed)) text = typed;
            Lines.Add($"{label}: {text}");
            return text;
        }
    }

    public enum MessageType
    {
        None,
        Info,
        Warning,
        Error,
    }

    public sealed class EditorGUILayout
    {
        public static void HelpBox(string message, MessageType type) => Drawing.Lines.Add($"{type}: {message}");

        public static string TextField(string label, string text, params GUILayoutOption[] options) =>
            Drawing.Field(label, text);

        public static string TextArea(string text, params GUILayoutOption[] options)
        {
            Drawing.Lines.Add(text);
            return text;
        }

        public static int Popup(
            string label, int selectedIndex, string[] displayedOptions, params GUILayoutOption[] options) =>
            Array.IndexOf(displayedOptions, Drawing.Field(label, displayedOptions[selectedIndex]));

        public static Vector2 BeginScrollView(Vector2 scrollPosition, params GUILayoutOption[] options) =>
            scrollPosition;

        public static void EndScrollView() { }
    }
}
