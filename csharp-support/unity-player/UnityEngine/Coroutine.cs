// Coroutines and invoked methods: what a script goes on with in a later frame.
using System;
using System.Collections;
using System.Collections.Generic;

namespace UnityEngine
{
    public class YieldInstruction { }
    public sealed class WaitForEndOfFrame : YieldInstruction { }
    public sealed class WaitForFixedUpdate : YieldInstruction { }

    public sealed class WaitForSeconds : YieldInstruction
    {
        internal readonly float Seconds;
        public WaitForSeconds(float seconds) => Seconds = seconds;
    }

    public abstract class CustomYieldInstruction : IEnumerator
    {
        public abstract bool keepWaiting { get; }
        public object Current => null;
        public bool MoveNext() => keepWaiting;
        public virtual void Reset() { }
    }

    public sealed class WaitUntil : CustomYieldInstruction
    {
        private readonly Func<bool> predicate;
        public WaitUntil(Func<bool> predicate) => this.predicate = predicate;
        public override bool keepWaiting => !predicate();
    }

    public sealed class WaitWhile : CustomYieldInstruction
    {
        private readonly Func<bool> predicate;
        public WaitWhile(Func<bool> predicate) => this.predicate = predicate;
        public override bool keepWaiting => predicate();
    }

    public class WaitForSecondsRealtime : CustomYieldInstruction
    {
        private float end = -1;
        public WaitForSecondsRealtime(float time) => waitTime = time;
        public float waitTime { get; set; }

        public override bool keepWaiting
        {
            get
            {
                if (end < 0) end = Time.realtimeSinceStartup + waitTime;
                if (Time.realtimeSinceStartup < end) return true;
                Reset();
                return false;
            }
        }

        public override void Reset() => end = -1;
    }

    public sealed class Coroutine : YieldInstruction
    {
        private static readonly List<Coroutine> All = new List<Coroutine>();
        // The outermost first: a yielded IEnumerator is a part of the coroutine that yields it, and is stopped with it.
        private readonly Stack<IEnumerator> routines = new Stack<IEnumerator>();
        private readonly MonoBehaviour owner;
        private readonly object key;
        private readonly bool invoked;
        private Coroutine waiting;
        private object awaited;
        private bool over;
        private double due;
        private int frame;

        // Its first part runs at once.
        internal Coroutine(MonoBehaviour owner, object key, IEnumerator routine, bool invoked)
        {
            (this.owner, this.key, this.invoked) = (owner, key, invoked);
            routines.Push(routine);
            All.Add(this);
            Advance();
        }

        /// <summary>Goes on with those that wait for this moment of the frame: that of WaitForFixedUpdate, that of
        /// WaitForEndOfFrame, or null, after Update.</summary>
        internal static void Run(Type moment)
        {
            // Coroutines that are started meanwhile have run already.
            for (int i = 0, count = All.Count; i < count; i++)
                if (All[i].Ready(moment)) All[i].Advance();
            All.RemoveAll(one => one.over);
        }

        /// <summary>Ends an owner's coroutines, or what it has invoked: all, or those with this name, routine or
        /// handle.</summary>
        internal static void Stop(MonoBehaviour owner, bool invoked, object key = null)
        {
            foreach (var one in All)
                if (one.Is(owner, invoked, key)) one.over = true;
        }

        internal static bool Any(MonoBehaviour owner, string key) => All.Exists(one => one.Is(owner, true, key));

        internal static IEnumerator Calls(MonoBehaviour owner, string method, double delay, double rate)
        {
            // By the time at which it was due: a late call makes the ones after it no later.
            var at = Time.Now + delay;
            yield return null;
            for (; ; at += rate)
            {
                while (Time.Now < at) yield return null;
                owner.Call(method);
                if (rate == 0 || !Any(owner, method)) yield break;
            }
        }

        private bool Is(MonoBehaviour owner, bool invoked, object key) =>
            !over && this.owner == owner && this.invoked == invoked
                && (key == null || Equals(this.key, key) || ReferenceEquals(this, key));

        private bool Ready(Type moment)
        {
            if (over || awaited is Coroutine) return false;
            if (awaited is WaitForFixedUpdate || awaited is WaitForEndOfFrame) return awaited.GetType() == moment;
            return moment == null && (invoked || frame < Time.Frames) && due <= Time.Now;
        }

        private void Advance()
        {
            try
            {
                while (!over && routines.Count > 0)
                {
                    if (!routines.Peek().MoveNext())
                    {
                        routines.Pop();
                        continue;
                    }
                    awaited = routines.Peek().Current;
                    if (awaited is IEnumerator inner) routines.Push(inner);
                    else if (!(awaited is Coroutine other) || !other.over)
                    {
                        if (awaited is Coroutine first) first.waiting = this;
                        due = awaited is WaitForSeconds wait ? Time.Now + wait.Seconds : 0;
                        frame = Time.Frames;
                        return;
                    }
                }
            }
            catch (Exception e)
            {
                over = true;
                Debug.LogException(e, owner);
            }
            if (over) return;
            over = true;
            waiting?.Advance();
        }
    }
}
