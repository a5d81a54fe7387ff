// Game objects and their components, with the life of a MonoBehaviour in the order that Unity documents.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using System.Threading;

namespace UnityEngine
{
    public sealed class GameObject : Object
    {
        private bool active = true;

        public GameObject() : this("New Game Object") { }

        public GameObject(string name)
        {
            this.name = name;
            transform = AddComponent<Transform>();
            LoadedScene.Objects.Add(this);
        }

        internal List<Component> Components { get; } = new List<Component>();

        public string tag { get; set; } = "Untagged";

        public int layer { get; set; }

        public bool CompareTag(string tag) => this.tag == tag;

        /// <summary>A thing that is seen, and that rays meet.</summary>
        public static GameObject CreatePrimitive(PrimitiveType type)
        {
            MainThread.Only(nameof(CreatePrimitive));
            // The player draws a sphere as a cube.
            if (type != PrimitiveType.Cube && type != PrimitiveType.Sphere)
                throw new NotSupportedException("the player has only cubes and spheres");
            var thing = new GameObject($"{type}");
            thing.AddComponent<MeshRenderer>();
            if (type == PrimitiveType.Cube) thing.AddComponent<BoxCollider>();
            else thing.AddComponent<SphereCollider>();
            return thing;
        }

        public Transform transform { get; }

        public bool activeSelf => active;

        public void SetActive(bool value)
        {
            MainThread.Only(nameof(SetActive));
            if (active == value) return;
            active = value;
            for (var i = 0; i < Components.Count; i++) (Components[i] as MonoBehaviour)?.Refresh();
        }

        public T AddComponent<T>() where T : Component => (T)AddComponent(typeof(T));

        public Component AddComponent(Type componentType)
        {
            MainThread.Only(nameof(AddComponent));
            if (componentType.IsDefined(typeof(DisallowMultipleComponent)) && GetComponent(componentType) != null)
            {
                Debug.LogError($"Can't add component '{componentType.Name}' to {name}: it allows no second one");
                return null;
            }
            foreach (var need in componentType.GetCustomAttributes<RequireComponent>())
                if (GetComponent(need.m_Type0) == null) AddComponent(need.m_Type0);
            var component = (Component)Activator.CreateInstance(componentType);
            component.Owner = this;
            Components.Add(component);
            (component as MonoBehaviour)?.Refresh();
            return component;
        }

        // By index: in Unity what is found costs no memory.
        public T GetComponent<T>()
        {
            for (var i = 0; i < Components.Count; i++)
                if (Components[i] is T found) return found;
            return default;
        }

        public T[] GetComponentsInChildren<T>(bool includeInactive) => Components.OfType<T>()
            .Concat(LoadedScene.Objects.Where(one => one.transform.IsPartOf(this)).SelectMany(one => one.GetComponentsInChildren<T>(true))).ToArray();

        public Component GetComponent(Type type) => Components.FirstOrDefault(type.IsInstanceOfType);
    }

    public class Component : Object
    {
        internal GameObject Owner { get; set; }

        internal override string Title
        {
            get => Owner.Title;
            set => Owner.Title = value;
        }

        public GameObject gameObject
        {
            get { MainThread.Only("get_gameObject"); return Owner; }
        }

        public Transform transform
        {
            get { MainThread.Only("get_transform"); return Owner.transform; }
        }

        public string tag { get => Owner.tag; set => Owner.tag = value; }

        public bool CompareTag(string tag) => Owner.CompareTag(tag);

        public T GetComponent<T>()
        {
            MainThread.Only(nameof(GetComponent));
            return Owner.GetComponent<T>();
        }

        public T GetComponentInParent<T>()
        {
            for (var here = transform; here != null; here = here.parent)
                if (here.Owner.GetComponent<T>() is T found) return found;
            return default;
        }

        public T[] GetComponentsInChildren<T>()
        {
            MainThread.Only(nameof(GetComponentsInChildren));
            // Inactive ones are left out, as in Unity.
            return LoadedScene.Objects.Where(thing => thing.activeSelf && thing.transform.IsBelow(transform)).SelectMany(thing => thing.Components).OfType<T>().ToArray();
        }
    }

    public class Behaviour : Component
    {
        private bool on = true;

        public bool enabled
        {
            get { MainThread.Only("get_enabled"); return on; }
            set
            {
                MainThread.Only("set_enabled");
                on = value;
                (this as MonoBehaviour)?.Refresh();
            }
        }

        public bool isActiveAndEnabled
        {
            get { MainThread.Only("get_isActiveAndEnabled"); return !Destroyed && on && Owner.activeSelf; }
        }
    }

    public class MonoBehaviour : Behaviour
    {
        private readonly CancellationTokenSource destroyed = new CancellationTokenSource();
        private readonly Dictionary<string, Action> messages = new Dictionary<string, Action>();
        private bool argument;
        private bool awoken;
        private bool running;
        private bool started;

        public bool useGUILayout { get; set; } = true;

        public CancellationToken destroyCancellationToken => destroyed.Token;

        public static void print(object message) => Debug.Log(message);

        /// <summary>Awake once, then OnEnable or OnDisable as this component is switched on or off.</summary>
        internal void Refresh()
        {
            if (!Destroyed && !awoken && Owner.activeSelf)
            {
                awoken = true;
                // In the editor alone, where a scene is loaded or a field changed.
                Send("OnValidate");
                Send("Awake");
            }
            if (!awoken || running == isActiveAndEnabled) return;
            running = !running;
            Send(running ? "OnEnable" : "OnDisable");
        }

        internal void BeginFrame()
        {
            if (!running || started) return;
            started = true;
            Send("Start");
        }

        /// <summary>A message of the frame: only a component that is on, and has started, gets it.</summary>
        internal void Tick(string message)
        {
            if (running && started) Send(message);
        }

        internal void End()
        {
            // As with a message: what a callback throws is logged.
            try { destroyed.Cancel(); }
            catch (AggregateException e) { Debug.LogException(e, this); }
            if (awoken) Send("OnDestroy");
        }

        /// <summary>A message to a component that is on, such as OnApplicationPause(true).</summary>
        internal void Tell(string message, bool value)
        {
            argument = value;
            if (running) Send(message);
        }

        /// <summary>Calls a message by its name, whatever its access. What it throws is logged and the Play goes on.</summary>
        internal void Send(string message)
        {
            if (!messages.TryGetValue(message, out var call)) messages[message] = call = Find(message);
            if (call == null) return;
            try
            {
                call();
            }
            catch (Exception e)
            {
                Debug.LogException(e, this);
            }
        }

        private Action Find(string message)
        {
            const BindingFlags any = BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic | BindingFlags.DeclaredOnly;
            for (var type = GetType(); type != typeof(MonoBehaviour); type = type.BaseType)
            {
                var method = type.GetMethod(message, any, null, Type.EmptyTypes, null) ?? type.GetMethod(message, any, null, new[] { typeof(bool) }, null);
                if (method == null) continue;
                if (method.ReturnType != typeof(void))
                {
                    Debug.LogError($"{type.Name}.{message} returns {method.ReturnType.Name}: it is left out, because the player runs no coroutines");
                    return null;
                }
                if (method.GetParameters().Length == 0) return (Action)method.CreateDelegate(typeof(Action), this);
                var told = (Action<bool>)method.CreateDelegate(typeof(Action<bool>), this);
                return () => told(argument);
            }
            return null;
        }
    }

    /// <summary>Every game object there is.</summary>
    internal static class LoadedScene
    {
        public static List<GameObject> Objects { get; } = new List<GameObject>();

        public static List<Object> Destroyed { get; } = new List<Object>();

        /// <summary>What stays when a scene is left.</summary>
        public static HashSet<GameObject> Kept { get; } = new HashSet<GameObject>();

        /// <summary>Materials and textures that a script has made and not destroyed, which Unity keeps when a scene is left.</summary>
        public static HashSet<Object> Made { get; } = new HashSet<Object>();

        public static void Remove(Object thing)
        {
            if (thing is GameObject whole)
            {
                whole.SetActive(false);
                foreach (var child in Objects.Where(one => one.transform.IsPartOf(whole)).ToArray()) Remove(child);
                foreach (var part in whole.Components.ToArray()) Remove(part);
                Objects.Remove(whole);
            }
            else if (thing is Component part)
            {
                if (part is Behaviour behaviour) behaviour.enabled = false;
                (part as MonoBehaviour)?.End();
                part.Owner.Components.Remove(part);
            }
            Made.Remove(thing);
            Kept.Remove(thing as GameObject);
            thing.Destroyed = true;
        }

        public static void RemoveDestroyed()
        {
            // By index: what OnDestroy destroys is removed as well.
            for (var i = 0; i < Destroyed.Count; i++)
                if (Destroyed[i] != null) Remove(Destroyed[i]);
            Destroyed.Clear();
        }
    }
}
