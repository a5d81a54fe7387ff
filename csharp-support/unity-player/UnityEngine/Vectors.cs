// Unity's vectors, as far as a lesson or a game's first scripts calculate with them.
using System;
using System.Globalization;
using System.Linq;

namespace UnityEngine
{
    public struct Vector2 : IFormattable
    {
        public float x, y;
        public Vector2(float x, float y) => (this.x, this.y) = (x, y);
        public static Vector2 zero => default;
        public static Vector2 one => new Vector2(1, 1);
        public static Vector2 up => new Vector2(0, 1);
        public static Vector2 down => new Vector2(0, -1);
        public static Vector2 left => new Vector2(-1, 0);
        public static Vector2 right => new Vector2(1, 0);
        public float sqrMagnitude => Dot(this, this);
        public float magnitude => (float)Math.Sqrt(sqrMagnitude);
        public Vector2 normalized => ((Vector3)this).normalized;
        public void Normalize() => this = normalized;
        public static float Dot(Vector2 lhs, Vector2 rhs) => (lhs.x * rhs.x) + (lhs.y * rhs.y);
        public static float Distance(Vector2 a, Vector2 b) => (a - b).magnitude;
        public static Vector2 Lerp(Vector2 a, Vector2 b, float t) => Vector3.Lerp(a, b, t);
        public static Vector2 MoveTowards(Vector2 current, Vector2 target, float maxDistanceDelta) =>
            Vector3.MoveTowards(current, target, maxDistanceDelta);
        public static Vector2 operator +(Vector2 a, Vector2 b) => new Vector2(a.x + b.x, a.y + b.y);
        public static Vector2 operator -(Vector2 a, Vector2 b) => new Vector2(a.x - b.x, a.y - b.y);
        public static Vector2 operator -(Vector2 a) => new Vector2(-a.x, -a.y);
        public static Vector2 operator *(Vector2 a, float d) => new Vector2(a.x * d, a.y * d);
        public static Vector2 operator *(float d, Vector2 a) => a * d;
        public static Vector2 operator /(Vector2 a, float d) => new Vector2(a.x / d, a.y / d);
        public static bool operator ==(Vector2 lhs, Vector2 rhs) => (lhs - rhs).sqrMagnitude < 1e-10f;
        public static bool operator !=(Vector2 lhs, Vector2 rhs) => !(lhs == rhs);
        public static implicit operator Vector2(Vector3 v) => new Vector2(v.x, v.y);
        public static implicit operator Vector3(Vector2 v) => new Vector3(v.x, v.y, 0);
        public override string ToString() => ToString(null, null);
        public string ToString(string format) => ToString(format, null);
        public string ToString(string format, IFormatProvider formatProvider) =>
            Vector3.Written(format ?? "F2", formatProvider, x, y);
    }

    public struct Vector3 : IEquatable<Vector3>, IFormattable
    {
        public float x, y, z;
        public Vector3(float x, float y, float z) => (this.x, this.y, this.z) = (x, y, z);
        public Vector3(float x, float y) : this(x, y, 0) { }

        public float this[int index]
        {
            get => index == 0
                ? x
                : index == 1 ? y : index == 2 ? z : throw new IndexOutOfRangeException("Invalid Vector3 index!");
            set
            {
                if (index == 0) x = value;
                else if (index == 1) y = value;
                else if (index == 2) z = value;
                else throw new IndexOutOfRangeException("Invalid Vector3 index!");
            }
        }

        public static Vector3 zero => default;
        public static Vector3 one => new Vector3(1, 1, 1);
        public static Vector3 forward => new Vector3(0, 0, 1);
        public static Vector3 back => new Vector3(0, 0, -1);
        public static Vector3 up => new Vector3(0, 1, 0);
        public static Vector3 down => new Vector3(0, -1, 0);
        public static Vector3 right => new Vector3(1, 0, 0);
        public static Vector3 left => new Vector3(-1, 0, 0);
        public float sqrMagnitude => Dot(this, this);
        public float magnitude => (float)Math.Sqrt(sqrMagnitude);
        // Of what is too short there is no direction.
        public Vector3 normalized => magnitude > 1e-5f ? this / magnitude : default;
        public void Normalize() => this = normalized;
        public static Vector3 Normalize(Vector3 value) => value.normalized;
        public static Vector3 Scale(Vector3 a, Vector3 b) => new Vector3(a.x * b.x, a.y * b.y, a.z * b.z);
        public static float Dot(Vector3 lhs, Vector3 rhs) => (lhs.x * rhs.x) + (lhs.y * rhs.y) + (lhs.z * rhs.z);
        // Unity's axes are left-handed, and so to the right times up is forward.
        public static Vector3 Cross(Vector3 lhs, Vector3 rhs) =>
            new Vector3((lhs.y * rhs.z) - (lhs.z * rhs.y), (lhs.z * rhs.x) - (lhs.x * rhs.z),
                (lhs.x * rhs.y) - (lhs.y * rhs.x));
        public static float Distance(Vector3 a, Vector3 b) => (a - b).magnitude;
        public static float Angle(Vector3 from, Vector3 to) =>
            Mathf.Acos(Mathf.Clamp(Dot(from.normalized, to.normalized), -1, 1)) * Mathf.Rad2Deg;
        public static float SignedAngle(Vector3 from, Vector3 to, Vector3 axis) =>
            Angle(from, to) * Mathf.Sign(Dot(axis, Cross(from, to)));
        public static Vector3 Project(Vector3 vector, Vector3 onNormal) =>
            onNormal.sqrMagnitude < Mathf.Epsilon ? zero : onNormal * (Dot(vector, onNormal) / onNormal.sqrMagnitude);
        public static Vector3 ProjectOnPlane(Vector3 vector, Vector3 planeNormal) =>
            vector - Project(vector, planeNormal);
        public static Vector3 ClampMagnitude(Vector3 vector, float maxLength) =>
            vector.sqrMagnitude > maxLength * maxLength ? vector.normalized * maxLength : vector;

        public static Vector3 MoveTowards(Vector3 current, Vector3 target, float maxDistanceDelta)
        {
            var way = target - current;
            return way.magnitude <= maxDistanceDelta ? target : current + (way * (maxDistanceDelta / way.magnitude));
        }

        public static Vector3 Lerp(Vector3 a, Vector3 b, float t) => LerpUnclamped(a, b, Mathf.Clamp01(t));
        public static Vector3 LerpUnclamped(Vector3 a, Vector3 b, float t) => a + ((b - a) * t);

        // The direction turns, and the length changes, both evenly.
        public static Vector3 Slerp(Vector3 a, Vector3 b, float t)
        {
            if (a == zero || b == zero) return Lerp(a, b, t);
            var direction = Quaternion.Slerp(Quaternion.identity, Quaternion.FromToRotation(a, b), t) * a.normalized;
            return direction * Mathf.Lerp(a.magnitude, b.magnitude, t);
        }

        // A spring that is damped so much that it does not swing.
        public static Vector3 SmoothDamp(Vector3 current, Vector3 target, ref Vector3 currentVelocity, float smoothTime)
        {
            var rate = 2 / Mathf.Max(smoothTime, 0.0001f);
            var (left, way) = (Mathf.Exp(-rate * Time.deltaTime), current - target);
            var push = (currentVelocity + (way * rate)) * Time.deltaTime;
            currentVelocity = (currentVelocity - (push * rate)) * left;
            return target + ((way + push) * left);
        }

        public static Vector3 operator +(Vector3 a, Vector3 b) => new Vector3(a.x + b.x, a.y + b.y, a.z + b.z);
        public static Vector3 operator -(Vector3 a, Vector3 b) => new Vector3(a.x - b.x, a.y - b.y, a.z - b.z);
        public static Vector3 operator -(Vector3 a) => new Vector3(-a.x, -a.y, -a.z);
        public static Vector3 operator *(Vector3 a, float d) => new Vector3(a.x * d, a.y * d, a.z * d);
        public static Vector3 operator *(float d, Vector3 a) => a * d;
        public static Vector3 operator /(Vector3 a, float d) => new Vector3(a.x / d, a.y / d, a.z / d);
        // As in Unity, two places that differ by less than 0.00001 are the same.
        public static bool operator ==(Vector3 lhs, Vector3 rhs) => (lhs - rhs).sqrMagnitude < 1e-10f;
        public static bool operator !=(Vector3 lhs, Vector3 rhs) => !(lhs == rhs);
        public bool Equals(Vector3 other) => x == other.x && y == other.y && z == other.z;
        public override bool Equals(object other) => other is Vector3 vector && Equals(vector);
        public override int GetHashCode() => HashCode.Combine(x, y, z);
        public override string ToString() => ToString(null, null);
        public string ToString(string format) => ToString(format, null);
        public string ToString(string format, IFormatProvider formatProvider) =>
            Written(format ?? "F2", formatProvider, x, y, z);

        internal static string Written(string format, IFormatProvider provider, params float[] parts)
        {
            var written = parts.Select(part => part.ToString(format, provider ?? CultureInfo.InvariantCulture));
            return $"({string.Join(", ", written)})";
        }
    }

    public struct Vector4
    {
        public float x, y, z, w;
        public Vector4(float x, float y, float z, float w) => (this.x, this.y, this.z, this.w) = (x, y, z, w);
    }

    public struct Vector2Int
    {
        public Vector2Int(int x, int y) => (this.x, this.y) = (x, y);
        public int x { get; set; }
        public int y { get; set; }
    }

    public struct Vector3Int
    {
        public Vector3Int(int x, int y, int z) => (this.x, this.y, this.z) = (x, y, z);
        public int x { get; set; }
        public int y { get; set; }
        public int z { get; set; }
    }

    /// <summary>Where something is, and how it is turned.</summary>
    [Serializable]
    public struct Pose
    {
        public Vector3 position;
        public Quaternion rotation;
        public Pose(Vector3 position, Quaternion rotation) => (this.position, this.rotation) = (position, rotation);
    }
}
