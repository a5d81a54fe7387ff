// Game objects and their components.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;

namespace UnityEngine
{
    public sealed class GameObject : Object
    {
        private readonly List<Type> coming = new List<Type>();
        private bool active = true;
        public GameObject() : this("New Game Object") { }
        public GameObject(string name) : this(name, true) { }

        internal GameObject(string name, bool active)
        {
            (this.name, this.active) = (name, active);
            transform = AddComponent<Transform>();
            LoadedScene.Objects.Add(this);
        }

        internal List<Component> Components { get; } = new List<Component>();
        public GameObject gameObject => this;
        public Transform transform { get; }
        public string tag { get; set; } = "Untagged";
        public int layer { get; set; }
        public bool activeSelf => active;
        public bool activeInHierarchy =>
            active && (transform?.Above == null || transform.Above.Owner.activeInHierarchy);
        public bool CompareTag(string tag) => this.tag == tag;

        /// <summary>An active one, by its name or by the names above it as well, such as Arm/Hand, and with / before
        /// those of a root.</summary>
        public static GameObject Find(string name)
        {
            MainThread.Only(nameof(Find));
            return LoadedScene.Active.FirstOrDefault(
                one => name.StartsWith("/", StringComparison.Ordinal) ? one.Path == name
                : one.Path.EndsWith($"/{name}", StringComparison.Ordinal));
        }

        public static GameObject FindWithTag(string tag) => FindGameObjectsWithTag(tag).FirstOrDefault();
        public static GameObject FindGameObjectWithTag(string tag) => FindWithTag(tag);
        public static GameObject[] FindGameObjectsWithTag(string tag)
        {
            MainThread.Only(nameof(FindGameObjectsWithTag));
            return LoadedScene.Active.Where(one => one.tag == tag).ToArray();
        }

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

        public void SetActive(bool value)
        {
            MainThread.Only(nameof(SetActive));
            if (active == value) return;
            active = value;
            Refresh();
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
            // What is needed may need this one, or a base class of it.
            coming.Add(componentType);
            foreach (var need in componentType.GetCustomAttributes<RequireComponent>())
                if (GetComponent(need.m_Type0) == null && !coming.Any(need.m_Type0.IsAssignableFrom))
                    AddComponent(need.m_Type0);
            coming.Remove(componentType);
            var component = (Component)Activator.CreateInstance(componentType);
            component.Owner = this;
            Components.Add(component);
            (component as MonoBehaviour)?.Refresh();
            return component;
        }

        // By index: in Unity what is found costs no memory.
        public T GetComponent<T>()
        {
            MainThread.Only(nameof(GetComponent));
            for (var i = 0; i < Components.Count; i++)
                if (Components[i] is T found) return found;
            return default;
        }

        public Component GetComponent(Type type) => Components.FirstOrDefault(type.IsInstanceOfType);
        public Component GetComponent(string type) => Components.FirstOrDefault(part => part.GetType().Name == type);
        public Component[] GetComponents(Type type) => Components.Where(type.IsInstanceOfType).ToArray();
        public bool TryGetComponent<T>(out T component) => (component = GetComponent<T>()) != null;
        public T[] GetComponents<T>() => Components.OfType<T>().ToArray();
        public T GetComponentInChildren<T>() => GetComponentsInChildren<T>().FirstOrDefault();
        public T[] GetComponentsInChildren<T>() => GetComponentsInChildren<T>(false);
        public T[] GetComponentsInChildren<T>(bool includeInactive) => transform.All
            .Where(one => includeInactive || one.Owner.activeInHierarchy).SelectMany(one => one.Owner.Components)
            .OfType<T>().ToArray();

        public T GetComponentInParent<T>()
        {
            for (var here = transform; here != null; here = here.parent)
                if (here.Owner.GetComponent<T>() is T found) return found;
            return default;
        }

        internal string Path => $"{transform.Above?.Owner.Path}/{Title}";

        /// <summary>Follows a change of this object's place, or of a switch of its own or above it.</summary>
        internal void Refresh()
        {
            var scripts = GetComponentsInChildren<MonoBehaviour>(true);
            // In Unity whoever comes does so in the order of the scripts, wherever they are.
            foreach (var script in activeInHierarchy ? scripts.OrderBy(one => one.Order).ToArray() : scripts)
                script.Refresh();
        }
    }

    public class Component : Object
    {
        internal GameObject Owner { get; set; }

        internal override string Title
        {
            get => Owner.Title;
            set => Owner.Title = value;
        }

        public GameObject gameObject => MainThread.Of("get_gameObject", Owner);
        public Transform transform => MainThread.Of("get_transform", Owner.transform);
        public string tag { get => Owner.tag; set => Owner.tag = value; }
        public bool CompareTag(string tag) => Owner.CompareTag(tag);
        public T GetComponent<T>() => Owner.GetComponent<T>();
        public Component GetComponent(Type type) => Owner.GetComponent(type);
        public Component GetComponent(string type) => Owner.GetComponent(type);
        public Component[] GetComponents(Type type) => Owner.GetComponents(type);
        public bool TryGetComponent<T>(out T component) => Owner.TryGetComponent(out component);
        public T[] GetComponents<T>() => Owner.GetComponents<T>();
        public T GetComponentInChildren<T>() => Owner.GetComponentInChildren<T>();
        public T GetComponentInParent<T>() => Owner.GetComponentInParent<T>();
        public T[] GetComponentsInChildren<T>() => Owner.GetComponentsInChildren<T>();
        public T[] GetComponentsInChildren<T>(bool includeInactive) =>
            Owner.GetComponentsInChildren<T>(includeInactive);
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

        public bool isActiveAndEnabled =>
            MainThread.Of("get_isActiveAndEnabled", !Destroyed && on && Owner.activeInHierarchy);
    }

    /// <summary>Every game object there is.</summary>
    internal static class LoadedScene
    {
        public static List<GameObject> Objects { get; } = new List<GameObject>();
        public static IEnumerable<GameObject> Active => Objects.Where(one => one.activeInHierarchy);
        /// <summary>What is to go, and at which of the game's times.</summary>
        public static List<(Object Thing, double Due)> Destroyed { get; } = new List<(Object, double)>();
        /// <summary>The objects that stay when a scene is left.</summary>
        public static HashSet<GameObject> Kept { get; } = new HashSet<GameObject>();
        /// <summary>Materials and textures that a script has made and not destroyed, which Unity keeps when a scene is
        /// left.</summary>
        public static HashSet<Object> Made { get; } = new HashSet<Object>();

        public static void Remove(Object thing)
        {
            if (thing is GameObject whole)
            {
                whole.SetActive(false);
                foreach (var child in whole.transform.Children.ToArray()) Remove(child.Owner);
                whole.transform.Above?.Children.Remove(whole.transform);
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
                if (Destroyed[i].Due <= Time.Now && Destroyed[i].Thing != null) Remove(Destroyed[i].Thing);
            Destroyed.RemoveAll(one => one.Thing == null);
        }
    }
}
