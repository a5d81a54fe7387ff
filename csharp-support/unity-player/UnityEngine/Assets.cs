// Assets lie beside the scenes; events are wired by the inspector.
using System;
using System.Collections.Generic;
using System.Reflection;

namespace UnityEngine
{
    /// <summary>What is in no scene: an asset, or a window of the editor.</summary>
    public class ScriptableObject : Object
    {
        public static T CreateInstance<T>() where T : ScriptableObject
        {
            MainThread.Only("CreateScriptableObjectInstanceFromType");
            var made = (T)Activator.CreateInstance(typeof(T));
            typeof(T).GetMethod("OnEnable",
                BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic)?.Invoke(made, null);
            return made;
        }
    }

    public sealed class Resources
    {
        /// <summary>By the path below a folder Resources, without the file's extension.</summary>
        internal static Dictionary<string, Object> Assets { get; } = new Dictionary<string, Object>();

        public static T Load<T>(string path) where T : Object
        {
            MainThread.Only(nameof(Load));
            return Assets.TryGetValue(path, out var asset) ? asset as T : null;
        }
    }
}

namespace UnityEngine.Events
{
    public delegate void UnityAction();
    public delegate void UnityAction<T0>(T0 arg0);
    public delegate void UnityAction<T0, T1>(T0 arg0, T1 arg1);

    public abstract class UnityEventBase
    {
        public void RemoveAllListeners() => Forget();
        private protected abstract void Forget();
    }

    public class UnityEvent : UnityEventBase
    {
        private event UnityAction Calls;
        private protected override void Forget() => Calls = null;
        public void AddListener(UnityAction call) => Calls += call;
        public void RemoveListener(UnityAction call) => Calls -= call;
        public void Invoke() => Calls?.Invoke();
    }

    public class UnityEvent<T0> : UnityEventBase
    {
        private event UnityAction<T0> Calls;
        private protected override void Forget() => Calls = null;
        public void AddListener(UnityAction<T0> call) => Calls += call;
        public void RemoveListener(UnityAction<T0> call) => Calls -= call;
        public void Invoke(T0 arg0) => Calls?.Invoke(arg0);
    }
}
