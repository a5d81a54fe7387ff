// Bodies, and the messages of things that overlap: OnTriggerEnter and OnCollisionEnter, Stay and Exit.
using System.Collections.Generic;
using System.Linq;

namespace UnityEngine
{
    public enum ForceMode { Force = 0, Impulse = 1, VelocityChange = 2, Acceleration = 5 }

    // It falls and flies; it turns by angularVelocity, and nothing stops it.
    public class Rigidbody : Component
    {
        private Vector3? goal;
        public float mass { get; set; } = 1;
        public bool useGravity { get; set; } = true;
        public bool isKinematic { get; set; }
        public Vector3 linearVelocity { get; set; }
        // Before Unity 6.
        public Vector3 velocity { get => linearVelocity; set => linearVelocity = value; }
        public Vector3 angularVelocity { get; set; }
        public Vector3 position { get => transform.position; set => transform.position = value; }
        public Quaternion rotation { get => transform.rotation; set => transform.rotation = value; }
        public void MovePosition(Vector3 position) => goal = position;
        public void AddForce(Vector3 force) => AddForce(force, ForceMode.Force);

        public void AddForce(Vector3 force, ForceMode mode)
        {
            MainThread.Only(nameof(AddForce));
            if (isKinematic) return;
            if (mode == ForceMode.Force || mode == ForceMode.Impulse) force /= mass;
            if (mode == ForceMode.Force || mode == ForceMode.Acceleration) force *= Time.fixedDeltaTime;
            linearVelocity += force;
        }

        internal void Step(float time)
        {
            if (goal is Vector3 place) position = place;
            goal = null;
            if (isKinematic) return;
            if (useGravity) linearVelocity += Physics.gravity * time;
            if (linearVelocity != Vector3.zero) position += linearVelocity * time;
            var turn = angularVelocity.magnitude * time * Mathf.Rad2Deg;
            if (turn > 0) rotation = Quaternion.AngleAxis(turn, angularVelocity) * rotation;
        }
    }

    public class Collision
    {
        internal Collider Other { get; set; }
        public Collider collider => Other;
        public Rigidbody rigidbody => Other.attachedRigidbody;
        public Transform transform => gameObject.transform;
        public GameObject gameObject => rigidbody != null ? rigidbody.gameObject : Other.gameObject;
    }

    internal static class Contacts
    {
        private static readonly List<Rigidbody> None = new List<Rigidbody>();
        private static HashSet<(Collider One, Collider Other)> before = new HashSet<(Collider One, Collider Other)>();

        /// <summary>The game is over.</summary>
        public static void Clear() => before.Clear();

        /// <summary>A step of physics.</summary>
        public static void Step(float time)
        {
            var bodies = Bodies();
            foreach (var body in bodies ?? None) body.Step(time);
            // A method of its own, or the lambda in it would be made in any case.
            if (bodies != null || before.Count > 0) TellAll();
        }

        private static void TellAll()
        {
            var now = Overlapping();
            // As in Unity, one that is switched off or destroyed leaves nobody.
            foreach (var pair in before.Where(pair => Are(pair.One, pair.Other) && !now.Contains(pair)))
                Tell(pair.One, pair.Other, "Exit");
            // A message may move or destroy what another pair has.
            foreach (var pair in now)
                if (Are(pair.One, pair.Other))
                    Tell(pair.One, pair.Other, before.Contains(pair) ? "Stay" : "Enter");
            before = now;
        }

        // Without one there is nothing to do, and no garbage.
        private static List<Rigidbody> Bodies()
        {
            List<Rigidbody> found = null;
            for (var i = 0; i < LoadedScene.Objects.Count; i++)
                if (LoadedScene.Objects[i].activeInHierarchy
                    && LoadedScene.Objects[i].GetComponent<Rigidbody>() is Rigidbody body)
                    (found ??= new List<Rigidbody>()).Add(body);
            return found;
        }

        private static HashSet<(Collider One, Collider Other)> Overlapping()
        {
            var all = Physics.All<Collider>(-1).Where(one => one.IsThere).ToList();
            var found = new HashSet<(Collider One, Collider Other)>();
            for (var i = 0; i < all.Count; i++)
                for (var k = i + 1; k < all.Count; k++)
                    if (CanTouch(all[i], all[k]) && Overlap(all[i], all[k])) found.Add((all[i], all[k]));
            return found;
        }

        private static bool Are(Collider one, Collider other) =>
            one != null && other != null && one.IsThere && other.IsThere;

        // Somebody must have a body; without a trigger, one that moves by physics.
        private static bool CanTouch(Collider one, Collider other)
        {
            var (body, second) = (one.attachedRigidbody, other.attachedRigidbody);
            if (body == second) return false;
            return one.isTrigger || other.isTrigger || Moves(body) || Moves(second);
        }

        private static bool Moves(Rigidbody body) => body != null && !body.isKinematic;

        // From each to the nearest point of the other one, until they have met.
        private static bool Overlap(Collider one, Collider other)
        {
            var place = one.transform.position;
            for (var i = 0; i < 30; i++) place = one.Nearest(other.Nearest(place));
            return other.Distance(place) < 1e-3f;
        }

        // As in Unity, scripts that are switched off are told as well.
        private static void Tell(Collider one, Collider other, string what)
        {
            var trigger = one.isTrigger || other.isTrigger;
            foreach (var (own, met) in new[] { (one, other), (other, one) })
                foreach (var thing in new[] { own.Owner, own.attachedRigidbody?.Owner }.Distinct())
                    foreach (var script in thing?.GetComponents<MonoBehaviour>() ?? new MonoBehaviour[0])
                        script.Touch(trigger ? $"OnTrigger{what}" : $"OnCollision{what}",
                            trigger ? met : (object)new Collision { Other = met });
        }
    }
}
