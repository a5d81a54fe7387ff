// Lesson 09 in Unity: what Unity has, such as a Vector3, as numbers.
//
//     Vector2, Vector3, Vector4    x, y, z, w as float32            Vector2Int, Vector3Int    the same as int32
//     Quaternion                   x, y, z, w, as Unity's constructor and scipy's Rotation.from_quat have them
//     Color                        r, g, b, a as float32            Color32                   the same as uint8
using UnityEngine;

namespace NetMQExample
{
    /// <summary>For Observed.Engine.</summary>
    public static class UnityValues
    {
        /// <summary>Its numbers; whatever is none of Unity's stays as it is.</summary>
        public static object Numbers(object value) => value switch
        {
            Vector2 v => new[] { v.x, v.y },
            Vector3 v => new[] { v.x, v.y, v.z },
            Vector4 v => new[] { v.x, v.y, v.z, v.w },
            Quaternion q => new[] { q.x, q.y, q.z, q.w },
            Color c => new[] { c.r, c.g, c.b, c.a },
            Color32 c => new[] { c.r, c.g, c.b, c.a },
            Vector2Int v => new[] { v.x, v.y },
            Vector3Int v => new[] { v.x, v.y, v.z },
            _ => value,
        };
    }
}
