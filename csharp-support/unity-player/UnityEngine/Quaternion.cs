// As much of Unity's rotations as a lesson needs to turn something.
using System;

namespace UnityEngine
{
    public struct Quaternion
    {
        private const float Same = 1 - 1e-6f;
        public float x, y, z, w;
        public Quaternion(float x, float y, float z, float w) => (this.x, this.y, this.z, this.w) = (x, y, z, w);
        public static Quaternion identity => new Quaternion(0, 0, 0, 1);
        // First around z, then x, then y.
        public static Quaternion Euler(float x, float y, float z) =>
            About(Vector3.up, y) * About(Vector3.right, x) * About(Vector3.forward, z);
        public static Quaternion Euler(Vector3 euler) => Euler(euler.x, euler.y, euler.z);
        // An axis of any length; none at all turns nothing.
        public static Quaternion AngleAxis(float angle, Vector3 axis) =>
            axis.sqrMagnitude == 0 ? identity : About(axis / axis.magnitude, angle);

        // From 0 to 360 degrees. Straight up or down, where y and z do the same, z is 0.
        public Vector3 eulerAngles
        {
            get
            {
                var (ahead, side, above) = (this * Vector3.forward, this * Vector3.right, this * Vector3.up);
                return Math.Abs(ahead.y) > 0.999999f
                    ? new Vector3(ahead.y < 0 ? 90 : 270, Positive(Degrees(-side.z, side.x)), 0)
                    : new Vector3(Positive(Down(ahead)), Positive(Degrees(ahead.x, ahead.z)),
                        Positive(Degrees(side.y, above.y)));
            }
            set => this = Euler(value);
        }

        // With its own up as near to the world's as can be: around y, then up or down.
        public static Quaternion LookRotation(Vector3 forward)
        {
            if (forward.sqrMagnitude == 0)
            {
                Debug.Log("Look rotation viewing vector is zero");
                return identity;
            }
            return Euler(Down(forward), Degrees(forward.x, forward.z), 0);
        }

        // With its own up as near to this one as can be.
        public static Quaternion LookRotation(Vector3 forward, Vector3 upwards)
        {
            var right = Vector3.Cross(upwards, forward);
            // Where there is no such up, Unity takes the shortest way.
            if (right.sqrMagnitude < 1e-12f)
                return forward.sqrMagnitude == 0 ? LookRotation(forward) : FromToRotation(Vector3.forward, forward);
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
        public static float Dot(Quaternion a, Quaternion b) => (a.x * b.x) + (a.y * b.y) + (a.z * b.z) + (a.w * b.w);
        public static float Angle(Quaternion a, Quaternion b) =>
            Mathf.Abs(Dot(a, b)) > Same ? 0 : 2 * Mathf.Rad2Deg * Half(a, b);
        // Both take the shorter of the two ways.
        public static Quaternion Lerp(Quaternion a, Quaternion b, float t) =>
            Mixed(a, 1 - Mathf.Clamp01(t), b, Mathf.Clamp01(t) * Mathf.Sign(Dot(a, b)));

        public static Quaternion Slerp(Quaternion a, Quaternion b, float t)
        {
            var (half, part) = (Half(a, b), Mathf.Clamp01(t));
            return half < 0.001f
                ? Lerp(a, b, t)
                : Mixed(a, Mathf.Sin((1 - part) * half), b, Mathf.Sin(part * half) * Mathf.Sign(Dot(a, b)));
        }

        public static Quaternion RotateTowards(Quaternion from, Quaternion to, float maxDegreesDelta) =>
            Angle(from, to) == 0 ? to : Slerp(from, to, maxDegreesDelta / Angle(from, to));

        public static bool operator ==(Quaternion lhs, Quaternion rhs) => Dot(lhs, rhs) > Same;
        public static bool operator !=(Quaternion lhs, Quaternion rhs) => !(lhs == rhs);
        public override string ToString() => Vector3.Written("F5", null, x, y, z, w);

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
            return new Quaternion((float)(half.x / length), (float)(half.y / length), (float)(half.z / length),
                (float)(w / length));
        }

        private static float Half(Quaternion a, Quaternion b) => Mathf.Acos(Mathf.Min(Mathf.Abs(Dot(a, b)), 1));

        private static Quaternion Mixed(Quaternion a, float from, Quaternion b, float to)
        {
            var mix = new Quaternion((a.x * from) + (b.x * to), (a.y * from) + (b.y * to), (a.z * from) + (b.z * to),
                (a.w * from) + (b.w * to));
            var length = Mathf.Sqrt(Dot(mix, mix));
            return new Quaternion(mix.x / length, mix.y / length, mix.z / length, mix.w / length);
        }

        // How far it looks below the horizon.
        private static float Down(Vector3 forward) =>
            Degrees(-forward.y, Math.Sqrt((forward.x * forward.x) + (forward.z * forward.z)));
        private static float Degrees(double y, double x) => (float)(Math.Atan2(y, x) * (180 / Math.PI));
        // Unity calls what is less than 0.0001 radians below 0 nothing, not 360.
        private static float Positive(float degrees) => degrees < -0.0001 * 180 / Math.PI ? degrees + 360 : degrees;

        private static Quaternion About(Vector3 axis, float degrees)
        {
            var half = degrees * Math.PI / 360;
            var part = axis * (float)Math.Sin(half);
            return new Quaternion(part.x, part.y, part.z, (float)Math.Cos(half));
        }
    }
}
