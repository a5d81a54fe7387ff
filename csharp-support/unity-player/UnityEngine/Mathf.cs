// Nearly every script calculates with these two: Mathf and Random.
using System;
using System.Linq;

namespace UnityEngine
{
    public struct Mathf
    {
        public const float PI = MathF.PI;
        public const float Infinity = float.PositiveInfinity;
        public const float NegativeInfinity = float.NegativeInfinity;
        public const float Deg2Rad = PI / 180;
        public const float Rad2Deg = 180 / PI;
        public static readonly float Epsilon = float.Epsilon;
        public static float Sin(float f) => (float)Math.Sin(f);
        public static float Cos(float f) => (float)Math.Cos(f);
        public static float Tan(float f) => (float)Math.Tan(f);
        public static float Asin(float f) => (float)Math.Asin(f);
        public static float Acos(float f) => (float)Math.Acos(f);
        public static float Atan(float f) => (float)Math.Atan(f);
        public static float Atan2(float y, float x) => (float)Math.Atan2(y, x);
        public static float Sqrt(float f) => (float)Math.Sqrt(f);
        public static float Pow(float f, float p) => (float)Math.Pow(f, p);
        public static float Exp(float power) => (float)Math.Exp(power);
        public static float Log(float f) => (float)Math.Log(f);
        public static float Log(float f, float p) => (float)Math.Log(f, p);
        public static float Log10(float f) => (float)Math.Log10(f);
        public static float Abs(float f) => Math.Abs(f);
        public static int Abs(int value) => Math.Abs(value);
        public static float Sign(float f) => f < 0 ? -1 : 1;
        public static float Min(float a, float b) => b < a ? b : a;
        public static float Min(params float[] values) => values.DefaultIfEmpty().Min();
        public static int Min(int a, int b) => Math.Min(a, b);
        public static int Min(params int[] values) => values.DefaultIfEmpty().Min();
        public static float Max(float a, float b) => b > a ? b : a;
        public static float Max(params float[] values) => values.DefaultIfEmpty().Max();
        public static int Max(int a, int b) => Math.Max(a, b);
        public static int Max(params int[] values) => values.DefaultIfEmpty().Max();
        public static float Clamp(float value, float min, float max) => value < min ? min : Min(value, max);
        public static int Clamp(int value, int min, int max) => value < min ? min : Min(value, max);
        public static float Clamp01(float value) => Clamp(value, 0, 1);
        public static float Floor(float f) => (float)Math.Floor(f);
        public static float Ceil(float f) => (float)Math.Ceiling(f);
        public static float Round(float f) => (float)Math.Round(f);
        public static int FloorToInt(float f) => (int)Floor(f);
        public static int CeilToInt(float f) => (int)Ceil(f);
        public static int RoundToInt(float f) => (int)Round(f);
        public static bool Approximately(float a, float b) =>
            Abs(b - a) < Max(0.000001f * Max(Abs(a), Abs(b)), Epsilon * 8);
        public static float Lerp(float a, float b, float t) => LerpUnclamped(a, b, Clamp01(t));
        public static float LerpUnclamped(float a, float b, float t) => a + t * (b - a);
        public static float LerpAngle(float a, float b, float t) => a + DeltaAngle(a, b) * Clamp01(t);
        public static float SmoothStep(float from, float to, float t) =>
            Lerp(from, to, Clamp01(t) * Clamp01(t) * (3 - 2 * Clamp01(t)));
        public static float InverseLerp(float a, float b, float value) => a == b ? 0 : Clamp01((value - a) / (b - a));
        public static float MoveTowards(float current, float target, float maxDelta) =>
            Abs(target - current) <= maxDelta ? target : current + Sign(target - current) * maxDelta;
        public static float Repeat(float t, float length) => Clamp(t - length * Floor(t / length), 0, length);
        public static float PingPong(float t, float length) => length - Abs(Repeat(t, 2 * length) - length);
        public static float DeltaAngle(float current, float target)
        {
            var turn = Repeat(target - current, 360);
            return turn > 180 ? turn - 360 : turn;
        }
    }

    /// <summary>Other numbers than Unity's for the same seed.</summary>
    public static class Random
    {
        private static System.Random source = new System.Random();
        /// <summary>From 0 to 1.</summary>
        public static float value => (float)source.NextDouble();
        public static void InitState(int seed) => source = new System.Random(seed);
        public static Vector3 onUnitSphere => rotation * Vector3.forward;
        public static Vector3 insideUnitSphere => onUnitSphere * Mathf.Pow(value, 1 / 3f);
        public static Vector2 insideUnitCircle =>
            Quaternion.AngleAxis(value * 360, Vector3.forward) * Vector3.up * Mathf.Sqrt(value);
        /// <summary>Each direction is as likely as any other.</summary>
        public static Quaternion rotation =>
            Quaternion.Euler(Mathf.Asin(Range(-1f, 1f)) * Mathf.Rad2Deg, value * 360, value * 360);
        /// <summary>Both ends included.</summary>
        public static float Range(float minInclusive, float maxInclusive) =>
            Mathf.Lerp(minInclusive, maxInclusive, value);
        /// <summary>The second end excluded.</summary>
        public static int Range(int minInclusive, int maxExclusive) => source.Next(minInclusive, maxExclusive);
    }
}
