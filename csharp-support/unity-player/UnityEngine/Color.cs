// Colours, as parts of red, green, blue and of what is not seen through.
using System;

namespace UnityEngine
{
    public struct Color
    {
        public float r, g, b, a;
        public Color(float r, float g, float b, float a) => (this.r, this.g, this.b, this.a) = (r, g, b, a);
        public Color(float r, float g, float b) : this(r, g, b, 1) { }
        public static Color red => new Color(1, 0, 0);
        public static Color green => new Color(0, 1, 0);
        public static Color blue => new Color(0, 0, 1);
        public static Color yellow => new Color(1, 235 / 255f, 4 / 255f);
        public static Color cyan => new Color(0, 1, 1);
        public static Color magenta => new Color(1, 0, 1);
        public static Color white => new Color(1, 1, 1);
        public static Color gray => new Color(0.5f, 0.5f, 0.5f);
        public static Color grey => gray;
        public static Color black => new Color(0, 0, 0);
        public static Color clear => default;
        public static Color Lerp(Color a, Color b, float t) => a + ((b - a) * Mathf.Clamp01(t));
        public static Color operator +(Color a, Color b) => new Color(a.r + b.r, a.g + b.g, a.b + b.b, a.a + b.a);
        public static Color operator -(Color a, Color b) => new Color(a.r - b.r, a.g - b.g, a.b - b.b, a.a - b.a);
        public static Color operator *(Color a, Color b) => new Color(a.r * b.r, a.g * b.g, a.b * b.b, a.a * b.a);
        public static Color operator *(Color a, float b) => new Color(a.r * b, a.g * b, a.b * b, a.a * b);
        public static Color operator *(float b, Color a) => a * b;
        public static bool operator ==(Color lhs, Color rhs) => Squares(lhs - rhs) < 1e-10f;
        public static bool operator !=(Color lhs, Color rhs) => !(lhs == rhs);
        public override string ToString() => $"RGBA{Vector3.Written("F3", null, r, g, b, a)}";
        private static float Squares(Color c) => (c.r * c.r) + (c.g * c.g) + (c.b * c.b) + (c.a * c.a);
    }

    public struct Color32
    {
        public byte r, g, b, a;
        public Color32(byte r, byte g, byte b, byte a) => (this.r, this.g, this.b, this.a) = (r, g, b, a);
        public static implicit operator Color(Color32 c) => new Color(c.r / 255f, c.g / 255f, c.b / 255f, c.a / 255f);
        public static implicit operator Color32(Color c) => new Color32(Byte(c.r), Byte(c.g), Byte(c.b), Byte(c.a));
        internal static byte Byte(float part) => (byte)Math.Round(Mathf.Clamp01(part) * 255);
    }
}
