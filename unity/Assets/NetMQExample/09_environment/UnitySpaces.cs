// Lesson 09 in Unity: what Unity has, such as a Vector3, as part of an observation: seen.Add(transform.position).
using UnityEngine;

namespace NetMQExample
{
    /// <summary>For SpaceWriter.</summary>
    public static class UnitySpaces
    {
        /// <summary>x and y.</summary>
        public static SpaceWriter Add(this SpaceWriter seen, Vector2 value) => seen.Add(value.x, value.y);

        /// <summary>x, y and z.</summary>
        public static SpaceWriter Add(this SpaceWriter seen, Vector3 value) => seen.Add(value.x, value.y, value.z);

        /// <summary>x, y, z and w.</summary>
        public static SpaceWriter Add(this SpaceWriter seen, Quaternion value) =>
            seen.Add(value.x, value.y, value.z, value.w);
    }
}
