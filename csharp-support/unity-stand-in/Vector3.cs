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

    public struct Quaternion
    {
        public float x;
        public float y;
        public float z;
        public float w;

        public Quaternion(float x, float y, float z, float w)
        {
            this.x = x;
            this.y = y;
            this.z = z;
            this.w = w;
        }

        public static Quaternion identity => new Quaternion(0, 0, 0, 1);

        // First around z, then x, then y.
        public static Quaternion Euler(float x, float y, float z) => About(Vector3.up, y) * About(Vector3.right, x) * About(Vector3.forward, z);

        // With its own up as near to the world's as can be: around y, then up or down.
        public static Quaternion LookRotation(Vector3 forward)
        {
            if (forward.sqrMagnitude == 0)
            {
                Debug.Log("Look rotation viewing vector is zero");
                return identity;
            }
            const double degrees = 180 / Math.PI;
            var level = Math.Sqrt((forward.x * forward.x) + (forward.z * forward.z));
            return Euler((float)(-Math.Atan2(forward.y, level) * degrees), (float)(Math.Atan2(forward.x, forward.z) * degrees), 0);
        }

        // With its own up as near to this one as can be.
        public static Quaternion LookRotation(Vector3 forward, Vector3 upwards)
        {
            var right = Vector3.Cross(upwards, forward);
            // Where there is no such up, Unity takes the shortest way.
            if (right.sqrMagnitude < 1e-12f) return forward.sqrMagnitude == 0 ? LookRotation(forward) : FromToRotation(Vector3.forward, forward);
            var first = FromToRotation(Vector3.right, right);
            return FromToRotation(first * Vector3.forward, forward, right) * first;
        }

        // The shortest way.
        public static Quaternion FromToRotation(Vector3 fromDirection, Vector3 toDirection)
        {
            var any = Math.Abs(fromDirection.x) < Math.Abs(fromDirection.y) ? Vector3.right : Vector3.up;
            return FromToRotation(fromDirection, toDirection, Vector3.Cross(fromDirection, any));
        }

        public static Quaternion Inverse(Quaternion rotation) => rotation.Back;

        public static Quaternion operator *(Quaternion lhs, Quaternion rhs) => new Quaternion(
            (lhs.w * rhs.x) + (lhs.x * rhs.w) + (lhs.y * rhs.z) - (lhs.z * rhs.y),
            (lhs.w * rhs.y) + (lhs.y * rhs.w) + (lhs.z * rhs.x) - (lhs.x * rhs.z),
            (lhs.w * rhs.z) + (lhs.z * rhs.w) + (lhs.x * rhs.y) - (lhs.y * rhs.x),
            (lhs.w * rhs.w) - (lhs.x * rhs.x) - (lhs.y * rhs.y) - (lhs.z * rhs.z));

        public static Vector3 operator *(Quaternion rotation, Vector3 point)
        {
            var turned = rotation * new Quaternion(point.x, point.y, point.z, 0) * rotation.Back;
            return new Vector3(turned.x, turned.y, turned.z);
        }

        internal Quaternion Back => new Quaternion(-x, -y, -z, w);

        // Around this axis, where the two are opposite and every way is as short as the others.
        private static Quaternion FromToRotation(Vector3 from, Vector3 to, Vector3 axis)
        {
            double lengths = Math.Sqrt((double)from.sqrMagnitude * to.sqrMagnitude);
            if (lengths == 0) return identity;
            var half = Vector3.Cross(from, to);
            var w = lengths + ((double)from.x * to.x) + ((double)from.y * to.y) + ((double)from.z * to.z);
            if (w < 1e-7 * lengths) (half, w) = (axis, 0);
            var length = Math.Sqrt((double)half.sqrMagnitude + (w * w));
            return new Quaternion((float)(half.x / length), (float)(half.y / length), (float)(half.z / length), (float)(w / length));
        }

        private static Quaternion About(Vector3 axis, float degrees)
        {
            var half = degrees * Math.PI / 360;
            var part = axis * (float)Math.Sin(half);
            return new Quaternion(part.x, part.y, part.z, (float)Math.Cos(half));
        }
    }
}
