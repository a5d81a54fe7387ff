// Physics as far as a script steps it itself: nothing moves by it, but what Unity would refuse is refused. Rays and
// spheres meet the colliders of cubes and spheres.
using System;
using System.Collections.Generic;
using System.Linq;

namespace UnityEngine
{
    public enum SimulationMode { FixedUpdate, Update, Script }

    // Only those of cubes and spheres are met.
    public class Collider : Component
    {
        // From a place to the nearest point of it; below 0: inside.
        internal virtual float Distance(Vector3 place) => float.PositiveInfinity;
    }

    public class BoxCollider : Collider
    {
        internal override float Distance(Vector3 place)
        {
            var inside = transform.rotation.Back * (place - transform.position);
            var half = transform.lossyScale * 0.5f;
            float x = Math.Abs(inside.x) - half.x, y = Math.Abs(inside.y) - half.y, z = Math.Abs(inside.z) - half.z;
            var outside = new Vector3(Math.Max(0, x), Math.Max(0, y), Math.Max(0, z)).magnitude;
            return outside > 0 ? outside : Math.Max(x, Math.Max(y, z));
        }
    }

    public class SphereCollider : Collider
    {
        internal override float Distance(Vector3 place)
        {
            var size = transform.lossyScale;
            return (place - transform.position).magnitude - (Math.Max(size.x, Math.Max(size.y, size.z)) / 2);
        }
    }

    public struct RaycastHit
    {
        internal Collider Met { get; set; }
        public Collider collider => Met;
        public float distance { get; set; }
        public Vector3 point { get; set; }
    }

    public struct LayerMask
    {
        public int value { get; set; }
        public static implicit operator int(LayerMask mask) => mask.value;
        public static implicit operator LayerMask(int intVal) => new LayerMask { value = intVal };
    }

    public class Physics
    {
        // All but the layer Ignore Raycast.
        public const int DefaultRaycastLayers = -5;
        private const float Near = 1e-4f;
        private static SimulationMode mode;

        public static SimulationMode simulationMode
        {
            get => MainThread.Of("get_simulationMode", mode);
            set => mode = MainThread.Of("set_simulationMode", value);
        }

        public static void Simulate(float step)
        {
            MainThread.Only(nameof(Simulate));
            if (mode != SimulationMode.Script)
                Debug.LogWarning("Physics.Simulate does nothing while the simulation mode is another than Script");
        }

        // Here they are always where their objects are.
        public static void SyncTransforms() => MainThread.Only(nameof(SyncTransforms));

        public static bool Raycast(
            Vector3 origin, Vector3 direction, out RaycastHit hitInfo, float maxDistance, int layerMask) =>
            Cast(origin, 0, direction, out hitInfo, maxDistance, layerMask);

        public static bool SphereCast(
            Vector3 origin, float radius, Vector3 direction, out RaycastHit hitInfo, float maxDistance,
            int layerMask) =>
            Cast(origin, radius, direction, out hitInfo, maxDistance, layerMask);

        private static bool Cast(
            Vector3 origin, float radius, Vector3 direction, out RaycastHit hit, float most, int layers)
        {
            MainThread.Only(nameof(Raycast));
            var way = direction.normalized;
            // As in Unity, what holds the origin is not met.
            var open = LoadedScene.Active.Where(thing => (layers & (1 << thing.layer)) != 0)
                .SelectMany(thing => thing.Components).OfType<Collider>()
                .Where(collider => collider.Distance(origin) > radius).ToList();
            hit = default;
            // As far as nothing can be met, and again from there.
            for (var far = 0f; open.Count > 0 && far <= most;)
            {
                var here = origin + (way * far);
                var nearest = open.OrderBy(collider => collider.Distance(here)).First();
                var left = nearest.Distance(here) - radius;
                if (left < Near)
                {
                    hit = new RaycastHit { Met = nearest, distance = far, point = here };
                    return true;
                }
                far += left;
            }
            return false;
        }
    }
}
