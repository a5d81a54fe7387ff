// A script on a game object, with its life in the order that Unity documents.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using System.Threading;

namespace UnityEngine
{
    public class MonoBehaviour : Behaviour
    {
        private const BindingFlags Own = BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic
            | BindingFlags.DeclaredOnly;
        // The arguments that messages have.
        private static readonly Type[] Messages = { typeof(bool), typeof(Collider), typeof(Collision) };
        private readonly CancellationTokenSource destroyed = new CancellationTokenSource();
        private readonly Dictionary<string, Action> messages = new Dictionary<string, Action>();
        private object argument;
        private bool awoken, running, started;
        /// <summary>Those of all scripts so far: by them a frame goes through the scripts.</summary>
        internal static readonly List<int> Orders = new List<int> { 0 };
        internal readonly int Order;

        public MonoBehaviour()
        {
            Order = GetType().GetCustomAttribute<DefaultExecutionOrder>()?.order ?? 0;
            if (Orders.Contains(Order)) return;
            Orders.Add(Order);
            Orders.Sort();
        }

        public bool useGUILayout { get; set; } = true;
        public CancellationToken destroyCancellationToken => destroyed.Token;
        public static void print(object message) => Debug.Log(message);
        public Coroutine StartCoroutine(IEnumerator routine) =>
            Begin(routine, routine ?? throw new NullReferenceException("routine is null"));
        public Coroutine StartCoroutine(string methodName) => StartCoroutine(methodName, null);
        public Coroutine StartCoroutine(string methodName, object value)
        {
            var values = value == null ? Array.Empty<object>() : new[] { value };
            return Method(methodName, values.Length)?.Invoke(this, values) is IEnumerator routine
                ? Begin(methodName, routine)
                : Refused($"Coroutine '{methodName}' couldn't be started!");
        }

        public void StopCoroutine(string methodName) => Coroutine.Stop(this, false, methodName);
        public void StopCoroutine(IEnumerator routine) =>
            Coroutine.Stop(this, false, routine ?? throw new NullReferenceException("routine is null"));
        public void StopCoroutine(Coroutine routine) =>
            Coroutine.Stop(this, false, routine ?? throw new NullReferenceException("routine is null"));
        public void StopAllCoroutines() => Coroutine.Stop(this, false);
        public void Invoke(string methodName, float time) => InvokeRepeating(methodName, time, 0);
        public void InvokeRepeating(string methodName, float time, float repeatRate)
        {
            MainThread.Only(nameof(Invoke));
            if (repeatRate <= 0.00001f && repeatRate != 0)
                throw new UnityException("Invoke repeat rate has to be larger than 0.00001F");
            _ = new Coroutine(this, methodName, Coroutine.Calls(this, methodName, time, repeatRate), true);
        }

        public void CancelInvoke() => Coroutine.Stop(this, true);
        public void CancelInvoke(string methodName) => Coroutine.Stop(this, true, methodName);
        public bool IsInvoking() => Coroutine.Any(this, null);
        public bool IsInvoking(string methodName) => Coroutine.Any(this, methodName);

        /// <summary>Awake once, then OnEnable or OnDisable as this component is switched on or off.</summary>
        internal void Refresh()
        {
            if (!Destroyed && !awoken && Owner.activeInHierarchy)
            {
                awoken = true;
                // In the editor alone, where a scene is loaded or a field changed.
                Send("OnValidate");
                Send("Awake");
            }
            if (awoken && running != isActiveAndEnabled)
            {
                running = !running;
                Send(running ? "OnEnable" : "OnDisable");
            }
            if (!Owner.activeInHierarchy) StopAllCoroutines();
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
            StopAllCoroutines();
            CancelInvoke();
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

        /// <summary>A message of physics, such as OnTriggerEnter: one that is off gets it as well.</summary>
        internal void Touch(string message, object value)
        {
            argument = value;
            if (awoken) Send(message);
        }

        /// <summary>Whether it has a method of this name that wants nothing.</summary>
        internal bool Can(string method) => Method(method, 0) != null;

        /// <summary>Calls what was invoked.</summary>
        internal void Call(string method)
        {
            if (Method(method, 0) == null)
                Debug.LogError($"Trying to Invoke method: {GetType().Name}.{method} couldn't be called.");
            Send(method);
        }

        /// <summary>Calls a message by its name, whatever its access. An exception is logged.</summary>
        internal void Send(string message)
        {
            if (!messages.TryGetValue(message, out var call)) messages[message] = call = Find(message);
            if (call == null) return;
            try { call(); }
            catch (Exception e) { Debug.LogException(e, this); }
        }

        private Action Find(string message)
        {
            var method = Method(message, 0) ?? Method(message, 1);
            var wants = method?.GetParameters().FirstOrDefault()?.ParameterType;
            if (method == null || wants != null && !Messages.Contains(wants)) return null;
            if (method.ReturnType == typeof(IEnumerator))
            {
                if (message == "Start") return () => StartCoroutine((IEnumerator)method.Invoke(this, null));
                Debug.LogError($"Script error: {GetType().Name}.{message}() can not be a coroutine.");
                return null;
            }
            if (wants == null)
                return method.ReturnType == typeof(void)
                    ? (Action)method.CreateDelegate(typeof(Action), this)
                    : () => method.Invoke(this, null);
            if (wants == typeof(bool)) return Told((Action<bool>)method.CreateDelegate(typeof(Action<bool>), this));
            return wants == typeof(Collider)
                ? Told((Action<Collider>)method.CreateDelegate(typeof(Action<Collider>), this))
                : Told((Action<Collision>)method.CreateDelegate(typeof(Action<Collision>), this));
        }

        private Action Told<T>(Action<T> call) => () => call((T)argument);

        // Also what a base class has for itself.
        private MethodInfo Method(string name, int parameters)
        {
            for (var type = GetType(); type != typeof(MonoBehaviour); type = type.BaseType)
                foreach (var method in type.GetMethods(Own))
                    if (method.Name == name && method.GetParameters().Length == parameters) return method;
            return null;
        }

        private Coroutine Begin(object key, IEnumerator routine)
        {
            MainThread.Only(nameof(StartCoroutine));
            return Owner.activeInHierarchy ? new Coroutine(this, key, routine, false)
                : Refused($"Coroutine couldn't be started because the the game object '{name}' is inactive!");
        }

        private static Coroutine Refused(string why)
        {
            Debug.LogError(why);
            return null;
        }
    }
}
