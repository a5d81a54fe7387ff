// The same in the plane of x and y: rays and circles meet the colliders of squares and circles.
using System;
using System.Linq;

namespace UnityEngine
{
    public class Collider2D : Behaviour
    {
        public bool isTrigger { get; set; }
        public Vector2 offset { get; set; }
        internal Vector2 Middle => transform.TransformPoint(offset);
        internal virtual float Distance(Vector2 place) => float.PositiveInfinity;
    }

    public sealed class BoxCollider2D : Collider2D
    {
        public Vector2 size { get; set; } = Vector2.one;

        internal override float Distance(Vector2 place)
        {
            var inside = transform.rotation.Back * (place - Middle);
            var half = Vector3.Scale(transform.lossyScale, size) * 0.5f;
            float x = Math.Abs(inside.x) - half.x, y = Math.Abs(inside.y) - half.y;
            var outside = new Vector2(Math.Max(0, x), Math.Max(0, y)).magnitude;
            return outside > 0 ? outside : Math.Max(x, y);
        }
    }

    public sealed class CircleCollider2D : Collider2D
    {
        public float radius { get; set; } = 0.5f;
        internal override float Distance(Vector2 place) => (place - Middle).magnitude
            - (radius * Math.Max(Math.Abs(transform.lossyScale.x), Math.Abs(transform.lossyScale.y)));
    }

    public struct RaycastHit2D
    {
        internal Collider2D Met { get; set; }
        public Collider2D collider => Met;
        public Transform transform => Met != null ? Met.transform : null;
        public float distance { get; set; }
        public float fraction { get; set; }
        public Vector2 point { get; set; }
        public static implicit operator bool(RaycastHit2D hit) => hit.collider != null;
    }

    public class Physics2D
    {
        public const int DefaultRaycastLayers = -5;
        public static RaycastHit2D Raycast(Vector2 origin, Vector2 direction) =>
            Raycast(origin, direction, float.PositiveInfinity);
        public static RaycastHit2D Raycast(Vector2 origin, Vector2 direction, float distance) =>
            Raycast(origin, direction, distance, DefaultRaycastLayers);
        public static RaycastHit2D Raycast(Vector2 origin, Vector2 direction, float distance, int layerMask) =>
            CircleCast(origin, 0, direction, distance, layerMask);

        // Unlike in 3D, a collider that holds the origin is met.
        public static RaycastHit2D CircleCast(
            Vector2 origin, float radius, Vector2 direction, float distance, int layerMask)
        {
            MainThread.Only(nameof(CircleCast));
            var way = direction.normalized;
            var open = Physics.All<Collider2D>(layerMask).Where(one => one.enabled).ToList();
            // Nothing is met beyond all of them.
            var most = Math.Min(distance, open.Select(one => one.Distance(origin)).DefaultIfEmpty().Max() + 1000);
            var met = Physics.First(open, (one, place) => one.Distance(place) - radius, origin, way, most, out var far);
            return met == null ? default : new RaycastHit2D
            {
                Met = met,
                distance = far,
                fraction = distance > 0 ? far / distance : 0,
                point = origin + (way * far),
            };
        }
    }
}
