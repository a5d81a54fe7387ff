// Physics in its least form: bodies fall and fly, and are told what they touch; nothing stops them. Rays and spheres
// meet the colliders of cubes and spheres.
using System;
using System.Collections.Generic;
using System.Linq;

namespace UnityEngine
{
    public enum SimulationMode { FixedUpdate, Update, Script }

    // Only those of cubes and spheres are met.
    public class Collider : Component
    {
        public bool enabled { get; set; } = true;
        public bool isTrigger { get; set; }
        public Rigidbody attachedRigidbody => Owner.GetComponentInParent<Rigidbody>();
        internal bool IsThere => enabled && Owner.activeInHierarchy;
        // From a place to the nearest point of it; below 0: inside.
        internal virtual float Distance(Vector3 place) => float.PositiveInfinity;
        internal virtual Vector3 Nearest(Vector3 place) => place;
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

        internal override Vector3 Nearest(Vector3 place)
        {
            var inside = transform.rotation.Back * (place - transform.position);
            var half = transform.lossyScale * 0.5f;
            var near = new Vector3(Mathf.Clamp(inside.x, -half.x, half.x), Mathf.Clamp(inside.y, -half.y, half.y),
                Mathf.Clamp(inside.z, -half.z, half.z));
            return transform.position + (transform.rotation * near);
        }
    }

    public class SphereCollider : Collider
    {
        internal override float Distance(Vector3 place)
        {
            var size = transform.lossyScale;
            return (place - transform.position).magnitude - (Math.Max(size.x, Math.Max(size.y, size.z)) / 2);
        }

        internal override Vector3 Nearest(Vector3 place) =>
            place + ((transform.position - place).normalized * Math.Max(0, Distance(place)));
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
        // Those of a new project; a test may give others a name.
        internal static readonly string[] Names =
            new[] { "Default", "TransparentFX", "Ignore Raycast", "", "Water", "UI" }.Concat(new string[26]).ToArray();
        public int value { get; set; }
        public static string LayerToName(int layer) => Names[layer] ?? "";
        // An empty name is none.
        public static int NameToLayer(string layerName) =>
            string.IsNullOrEmpty(layerName) ? -1 : Array.IndexOf(Names, layerName);
        public static int GetMask(params string[] layerNames) =>
            layerNames.Select(NameToLayer).Where(layer => layer >= 0).Aggregate(0, (mask, layer) => mask | 1 << layer);
        public static implicit operator int(LayerMask mask) => mask.value;
        public static implicit operator LayerMask(int intVal) => new LayerMask { value = intVal };
    }

    public class Physics
    {
        // All but the layer Ignore Raycast.
        public const int DefaultRaycastLayers = -5;
        private static SimulationMode mode;
        public static Vector3 gravity { get; set; } = new Vector3(0, -9.81f, 0);

        public static SimulationMode simulationMode
        {
            get => MainThread.Of("get_simulationMode", mode);
            set => mode = MainThread.Of("set_simulationMode", value);
        }

        public static void Simulate(float step)
        {
            MainThread.Only(nameof(Simulate));
            if (mode == SimulationMode.Script) Contacts.Step(step);
            else
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
            // As in Unity, a collider that holds the origin is not met.
            var open = All<Collider>(layers).Where(one => one.IsThere && one.Distance(origin) > radius);
            var met = First(
                open.ToList(), (one, place) => one.Distance(place) - radius, origin, way, most, out var far);
            hit = met == null ? default : new RaycastHit { Met = met, distance = far, point = origin + (way * far) };
            return met != null;
        }

        internal static IEnumerable<T> All<T>(int layers) =>
            LoadedScene.Active.Where(thing => (layers & (1 << thing.layer)) != 0)
                .SelectMany(thing => thing.Components).OfType<T>();

        /// <summary>As far as nothing can be met, and again from there.</summary>
        internal static T First<T>(List<T> open, Func<T, Vector3, float> distance, Vector3 origin, Vector3 way,
            float most, out float far)
            where T : class
        {
            for (far = 0; open.Count > 0 && far <= most;)
            {
                var here = origin + (way * far);
                var nearest = open.OrderBy(one => distance(one, here)).First();
                var left = distance(nearest, here);
                if (left < 1e-4f) return nearest;
                far += left;
            }
            return null;
        }
    }
}
