// OnGUI draws with these. A terminal has no place for it: the last text and picture are kept; nobody clicks or types.
using System;

namespace UnityEngine
{
    public struct Rect
    {
        public Rect(float x, float y, float width, float height) =>
            (this.x, this.y, this.width, this.height) = (x, y, width, height);
        public float x { get; set; }
        public float y { get; set; }
        public float width { get; set; }
        public float height { get; set; }
        public override string ToString() =>
            FormattableString.Invariant($"(x:{x:F2}, y:{y:F2}, width:{width:F2}, height:{height:F2})");
    }

    public class GUI
    {
        internal static string Drawn { get; private set; } = "";
        internal static Texture Picture { get; private set; }
        /// <summary>Whether the button with this text is pressed.</summary>
        internal static Func<string, bool> Pressed { get; set; } = text => false;
        public static Color color { get; set; } = Color.white;
        public static void Label(Rect position, string text) => Drawn = text;
        public static void Box(Rect position, string text) => Drawn = text;
        public static void DrawTexture(Rect position, Texture image) => Picture = image;
        public static bool Button(Rect position, string text) => Pressed(text);
        public static bool Toggle(Rect position, bool value, string text) => value;
        public static string TextField(Rect position, string text) => text;
        public static float HorizontalSlider(Rect position, float value, float leftValue, float rightValue) => value;
    }

    public sealed class GUILayoutOption
    {
        internal GUILayoutOption() { }
    }

    public class GUILayout
    {
        public static void BeginArea(Rect screenRect) { }
        public static void EndArea() { }
        public static void BeginHorizontal(params GUILayoutOption[] options) { }
        public static void EndHorizontal() { }
        public static void BeginVertical(params GUILayoutOption[] options) { }
        public static void EndVertical() { }
        public static void Space(float pixels) { }
        public static void FlexibleSpace() { }
        public static GUILayoutOption Width(float width) => new GUILayoutOption();
        public static GUILayoutOption ExpandWidth(bool expand) => new GUILayoutOption();
        public static GUILayoutOption ExpandHeight(bool expand) => new GUILayoutOption();
        public static GUILayoutOption Height(float height) => new GUILayoutOption();
        public static void Label(string text, params GUILayoutOption[] options) => GUI.Label(default, text);
        public static void Box(string text, params GUILayoutOption[] options) => GUI.Label(default, text);
        public static bool Button(string text, params GUILayoutOption[] options) => GUI.Pressed(text);
        public static bool Toggle(bool value, string text, params GUILayoutOption[] options) => value;
        public static string TextField(string text, params GUILayoutOption[] options) => text;
        public static float HorizontalSlider(
            float value, float leftValue, float rightValue, params GUILayoutOption[] options) => value;
    }

    public sealed class TextMesh : Component
    {
        public string text { get; set; } = "";
        public Color color { get; set; } = Color.white;
    }
}
