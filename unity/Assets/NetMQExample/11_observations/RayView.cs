// Lesson 11 in Unity, rays: what is where around a thing, as ML-Agents' ray sensor sees it.
//
//     var rays = new RayView(transform, 3, 70, 20, 0.5f, Physics.DefaultRaycastLayers, "wall", "coin");
//     MessageArray seen = rays.Observe();                 float32 [28]: 7 rays, each with two tags and two more numbers
//
// Of each ray there is 1 at the tag of what it has met, else 0; then 1 if it has met nothing; then how far it came,
// from 0 to 1. The first ray looks ahead, the next one to the right of it, then to the left, and so on outwards.
using System;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Casts rays when it is asked to. For the main thread.</summary>
    public sealed class RayView
    {
        private readonly Transform from;
        private readonly int rays, layers;
        private readonly float degrees, length, radius;
        private readonly string[] tags;

        /// <summary>Rays from where a thing is, in the plane of its own x and z.</summary>
        /// <param name="from">The thing; where it has the scale 2, rays are twice as long.</param>
        /// <param name="raysPerDirection">How many there are to each side of the one ahead.</param>
        /// <param name="maxRayDegrees">From the one ahead to the last one; 180: all around.</param>
        /// <param name="rayLength">In metres.</param>
        /// <param name="sphereCastRadius">How thick they are, in metres; 0: as thin as a ray.</param>
        public RayView(Transform from, int raysPerDirection, float maxRayDegrees, float rayLength,
            float sphereCastRadius, int layerMask, params string[] detectableTags)
        {
            this.from = Require.Given("from", from);
            rays = 2 * Require.Count("raysPerDirection", raysPerDirection, 0) + 1;
            degrees = raysPerDirection > 0 ? maxRayDegrees / raysPerDirection : 0;
            length = rayLength;
            radius = sphereCastRadius;
            layers = layerMask;
            tags = Require.Given("detectableTags", detectableTags);
            Size = rays * (tags.Length + 2);
        }

        /// <summary>How many numbers there are; all are from 0 to 1.</summary>
        public int Size { get; }

        /// <summary>The numbers of all rays now: float32.</summary>
        public MessageArray Observe()
        {
            var seen = new float[Size];
            Observe(seen);
            var data = new byte[Size * sizeof(float)];
            Buffer.BlockCopy(seen, 0, data, 0, data.Length);
            return new MessageArray("float32", data, Size);
        }

        /// <summary>The same, without garbage.</summary>
        /// <param name="into">At least <see cref="Size"/> numbers.</param>
        public void Observe(float[] into)
        {
            // Of what a script has moved since the last step of physics, rays know only then.
            Physics.SyncTransforms();
            Array.Clear(into, 0, Size);
            for (var ray = 0; ray < rays; ray++) Cast(ray, into, ray * (tags.Length + 2));
        }

        private void Cast(int ray, float[] into, int at)
        {
            // 0 ahead, then 1 to the right, 1 to the left, 2 to the right, …
            var aside = (ray + 1) / 2 * degrees * Mathf.Deg2Rad * (ray % 2 == 1 ? 1 : -1);
            var local = new Vector3(Mathf.Sin(aside), 0, Mathf.Cos(aside)) * length;
            var way = from.TransformDirection(Vector3.Scale(local, from.lossyScale));
            var far = way.magnitude;
            var thick = radius * Math.Max(from.lossyScale.x, Math.Max(from.lossyScale.y, from.lossyScale.z));
            var met = thick > 0
                ? Physics.SphereCast(from.position, thick, way, out var hit, far, layers)
                : Physics.Raycast(from.position, way, out hit, far, layers);
            for (var tag = 0; met && tag < tags.Length; tag++)
                if (hit.collider.CompareTag(tags[tag])) into[at + tag] = 1;
            into[at + tags.Length] = met ? 0 : 1;
            into[at + tags.Length + 1] = met && far > 0 ? hit.distance / far : 1;
        }
    }
}
