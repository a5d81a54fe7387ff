// Every thing in a scene has a name, and an end after which it equals null.
using System;
using System.Linq;

namespace UnityEngine
{
    public class Object
    {
        internal bool Destroyed { get; set; }
        // A component has none of its own: it answers with that of its game object.
        public HideFlags hideFlags { get; set; }
        internal virtual string Title { get; set; } = "";
        public string name { get => MainThread.Of("GetName", Title); set => Title = MainThread.Of("SetName", value); }
        public static void Destroy(Object obj) => Destroy(obj, 0);

        /// <summary>Takes effect at the end of the frame, or so many seconds later.</summary>
        public static void Destroy(Object obj, float t)
        {
            MainThread.Only(nameof(Destroy));
            if (obj != null) LoadedScene.Destroyed.Add((obj, Time.Now + t));
        }

        public static void DestroyImmediate(Object obj)
        {
            MainThread.Only(nameof(DestroyImmediate));
            if (obj != null) LoadedScene.Remove(obj);
        }

        public static void DontDestroyOnLoad(Object target)
        {
            MainThread.Only(nameof(DontDestroyOnLoad));
            LoadedScene.Kept.Add((target as Component)?.gameObject ?? (GameObject)target);
        }

        public static T Instantiate<T>(T original) where T : Object => Copies.Of(original);
        public static T Instantiate<T>(T original, Transform parent)
            where T : Object => Instantiate(original, parent, false);

        public static T Instantiate<T>(T original, Transform parent, bool worldPositionStays) where T : Object =>
            Copies.Of(original, one => one.SetParent(parent, worldPositionStays));

        public static T Instantiate<T>(T original, Vector3 position, Quaternion rotation) where T : Object =>
            Copies.Of(original, one => one.SetPositionAndRotation(position, rotation));

        public static T Instantiate<T>(T original, Vector3 position, Quaternion rotation, Transform parent)
            where T : Object =>
            Copies.Of(original, one =>
            {
                one.SetParent(parent);
                one.SetPositionAndRotation(position, rotation);
            });

        public static T FindObjectOfType<T>() where T : Object => FindAnyObjectByType<T>();
        public static T FindFirstObjectByType<T>() where T : Object => FindAnyObjectByType<T>();
        public static T FindAnyObjectByType<T>()
            where T : Object => FindObjectsByType<T>(FindObjectsInactive.Exclude).FirstOrDefault();
        public static Object[] FindObjectsOfType(Type type) =>
            FindObjectsByType<Object>().Where(type.IsInstanceOfType).ToArray();
        public static T[] FindObjectsOfType<T>() where T : Object => FindObjectsByType<T>(FindObjectsInactive.Exclude);
        public static T[] FindObjectsByType<T>() where T : Object => FindObjectsByType<T>(FindObjectsInactive.Exclude);
        public static T[] FindObjectsByType<T>(FindObjectsSortMode sortMode)
            where T : Object => FindObjectsByType<T>(FindObjectsInactive.Exclude);
        public static T[] FindObjectsByType<T>(FindObjectsInactive findObjectsInactive, FindObjectsSortMode sortMode)
            where T : Object =>
            FindObjectsByType<T>(findObjectsInactive);

        public static T[] FindObjectsByType<T>(FindObjectsInactive findObjectsInactive) where T : Object
        {
            MainThread.Only(nameof(FindObjectsByType));
            return LoadedScene.Objects.Where(
                one => findObjectsInactive == FindObjectsInactive.Include || one.activeInHierarchy)
                .SelectMany(one => one.Components.Prepend<Object>(one)).OfType<T>().ToArray();
        }

        public static implicit operator bool(Object exists) => exists != null;

        public static bool operator ==(Object x, Object y) =>
            ReferenceEquals(x, y) || (IsGone(x) && IsGone(y));

        public static bool operator !=(Object x, Object y) => !(x == y);
        public override bool Equals(object other) => other is Object thing ? this == thing : other == null && Destroyed;
        public override int GetHashCode() => base.GetHashCode();
        public int GetInstanceID() => MainThread.Of("GetInstanceID", GetHashCode());
        public override string ToString() => $"{Title} ({GetType().FullName})";
        private static bool IsGone(Object thing) => thing is null || thing.Destroyed;
    }

    [Flags]
    public enum HideFlags { None = 0, HideInHierarchy = 1, HideInInspector = 2, DontSave = 52, HideAndDontSave = 61 }
    public enum FindObjectsInactive { Exclude, Include }
    public enum FindObjectsSortMode { None, InstanceID }

    public class UnityException : SystemException
    {
        public UnityException(string message) : base(message) { }
    }

    /// <summary>The thread that the player runs on, and the refusal that any other one gets.</summary>
    internal static class MainThread
    {
        public static int? Id { get; set; }
        public static bool IsThis => Id == null || Id == Environment.CurrentManagedThreadId;

        public static T Of<T>(string api, T value)
        {
            Only(api);
            return value;
        }

        public static void Only(string api)
        {
            if (IsThis) return;
            throw new UnityException(
                $"{api} can only be called from the main thread.\n" +
                "Constructors and field initializers will be executed from the loading thread when loading a scene.\n" +
                "Don't use this function in the constructor or field initializers, instead move initialization " +
                "code to the Awake or Start function.");
        }
    }
}
