// As much of Unity's geometry as a lesson needs to move something.
using System;
using System.Globalization;

namespace UnityEngine
{
    public struct Vector3 : IEquatable<Vector3>
    {
        public float x;
        public float y;
        public float z;

        public Vector3(float x, float y, float z)
        {
            this.x = x;
            this.y = y;
            this.z = z;
        }

        public static Vector3 zero => default;

        public static Vector3 one => new Vector3(1, 1, 1);

        public static Vector3 forward => new Vector3(0, 0, 1);

        public static Vector3 up => new Vector3(0, 1, 0);

        public static Vector3 right => new Vector3(1, 0, 0);

        public float magnitude => (float)Math.Sqrt(sqrMagnitude);

        public float sqrMagnitude => (x * x) + (y * y) + (z * z);

        // Of what is too short there is no direction.
        public Vector3 normalized => magnitude > 1e-5f ? this / magnitude : default;

        public static Vector3 Scale(Vector3 a, Vector3 b) => new Vector3(a.x * b.x, a.y * b.y, a.z * b.z);

        public static float Distance(Vector3 a, Vector3 b) => (a - b).magnitude;

        // Unity's axes are left-handed, and so to the right times up is forward.
        public static Vector3 Cross(Vector3 lhs, Vector3 rhs) =>
            new Vector3((lhs.y * rhs.z) - (lhs.z * rhs.y), (lhs.z * rhs.x) - (lhs.x * rhs.z), (lhs.x * rhs.y) - (lhs.y * rhs.x));

        public static Vector3 MoveTowards(Vector3 current, Vector3 target, float maxDistanceDelta)
        {
            var way = target - current;
            return way.magnitude <= maxDistanceDelta ? target : current + (way * (maxDistanceDelta / way.magnitude));
        }

        public static Vector3 Lerp(Vector3 a, Vector3 b, float t) => a + ((b - a) * Math.Min(Math.Max(t, 0), 1));

        public static Vector3 operator +(Vector3 a, Vector3 b) => new Vector3(a.x + b.x, a.y + b.y, a.z + b.z);

        public static Vector3 operator -(Vector3 a, Vector3 b) => new Vector3(a.x - b.x, a.y - b.y, a.z - b.z);

        public static Vector3 operator *(Vector3 a, float d) => new Vector3(a.x * d, a.y * d, a.z * d);

        public static Vector3 operator *(float d, Vector3 a) => a * d;

        public static Vector3 operator /(Vector3 a, float d) => new Vector3(a.x / d, a.y / d, a.z / d);

        // As in Unity, two places that differ by less than 0.00001 are the same.
        public static bool operator ==(Vector3 lhs, Vector3 rhs) => (lhs - rhs).sqrMagnitude < 1e-10f;

        public static bool operator !=(Vector3 lhs, Vector3 rhs) => !(lhs == rhs);

        public bool Equals(Vector3 other) => x == other.x && y == other.y && z == other.z;

        public override bool Equals(object other) => other is Vector3 vector && Equals(vector);

        public override int GetHashCode() => HashCode.Combine(x, y, z);

        public override string ToString() => ToString("F2");

        public string ToString(string format)
        {
            var culture = CultureInfo.InvariantCulture;
            return $"({x.ToString(format, culture)}, {y.ToString(format, culture)}, {z.ToString(format, culture)})";
        }
    }
}
