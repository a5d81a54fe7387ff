// The lessons' components share this: each has a network thread, and a queue from there to Update. A lesson overrides
// Talk, which runs on that thread, so that no frame waits for the network; only what it hands to Update may touch the
// scene.
//
// For a component of your own, derive from it; an Update of its own overrides this one, and calls base.Update().
using System;
using System.Collections;
using System.Collections.Concurrent;
using System.Collections.Generic;
using System.Threading;
using System.Threading.Tasks;
using UnityEngine;
using UnityEngine.Profiling;
using Debug = UnityEngine.Debug;
using Stopwatch = System.Diagnostics.Stopwatch;

namespace NetMQExample
{
    /// <summary>A component that talks to the network on a thread of its own while it is enabled.</summary>
    public abstract class NetworkBehaviour : ConnectedBehaviour
    {
        // How much may wait for Update. A thread that has more waits, so that a fast server can fill
        // neither a frame nor the memory, also while the editor is paused and no Update comes.
        private const int MostQueued = 50;
        // Update spends at most 2 ms in a frame. One action is always done, however long it takes.
        private static readonly long BudgetTicks = Stopwatch.Frequency / 500;
        // For the main thread only. It outlives a Play where Unity keeps statics, and holds only what has not ended.
        private static readonly List<Run> Runs = new List<Run>();
        [ThreadStatic] private static Run own;

        private Run run;
        private bool silent, updated;

        public override bool Done => run != null && !run.Thread.IsAlive && run.ForUpdate.Count == 0;

        /// <summary>Whether something is still to be done in Update, such as to log a line. Disabling the component
        /// drops it.</summary>
        protected bool Waiting => run != null && run.ForUpdate.Count > 0;

        /// <summary>Whether it has no thread, or one that was told to end.</summary>
        protected bool Ending => run == null || run.Stop.IsCancellationRequested;

        /// <summary>The lesson, on the network thread. An exception is logged as the reason for giving up.</summary>
        /// <param name="stop">Cancelled when the component is disabled. Look at least every 50 ms.</param>
        protected abstract void Talk(CancellationToken stop);

        /// <summary>Logs a line in Update. For any thread.</summary>
        protected void Log(string line) => InUpdate(() => Debug.Log(line));

        /// <summary>Raises an event in Update, after the lines logged before. For any thread.</summary>
        protected void Arrive<T>(Arrival<T> arrival, T value) => InUpdate(() => arrival.Raise(value));

        /// <summary>Has something done in Update, and waits while much else is to be done there. For any thread; on
        /// Unity's own it is done at once.</summary>
        /// <param name="action">It may touch the scene; after Stop it is dropped.</param>
        protected void InUpdate(Action action)
        {
            // A timer or a task belongs to no run: it means the one that there is now.
            var one = own ?? run;
            if (one == null || one.UnityThread == Thread.CurrentThread)
            {
                action();
                return;
            }
            try
            {
                one.ForUpdate.Add(action, one.Stop.Token);
            }
            catch (OperationCanceledException)
            {
                // A client that logs while it is made must not be left half made: its next wait hears of the Stop.
            }
        }

        /// <summary>Has something made in Update, and waits for it. For the network thread.</summary>
        protected T FromUpdate<T>(Func<T> make)
        {
            var task = new Task<T>(make);
            InUpdate(task.RunSynchronously);
            // Unlike Wait it throws nothing of the task's, and GetResult throws that unwrapped.
            Task.WaitAny(new Task[] { task }, (own ?? run)?.Stop.Token ?? default);
            return task.GetAwaiter().GetResult();
        }

        /// <summary>Receives, for the network thread. An outage ends nothing: it is logged once, until something comes.
        /// </summary>
        /// <param name="receive">It throws a TimeoutException if nothing comes.</param>
        /// <returns>False if nothing came.</returns>
        protected bool TryReceive<T>(Func<T> receive, out T received)
        {
            try
            {
                received = receive();
                silent = false;
                return true;
            }
            catch (TimeoutException e)
            {
                if (!silent) Log($"trouble: {e.Message}");
                silent = true;
                received = default;
                return false;
            }
        }

        protected override void Begin()
        {
            // A component that was destroyed just now gets no OnApplicationQuit, and its thread may still be ending.
            Application.quitting -= EndAll;
            Application.quitting += EndAll;
#if UNITY_EDITOR
            // A script was changed while playing: its assembly is unloaded with everything that runs in it.
            UnityEditor.AssemblyReloadEvents.beforeAssemblyReload -= EndAll;
            UnityEditor.AssemblyReloadEvents.beforeAssemblyReload += EndAll;
#endif
            run = new Run(this);
            Runs.RemoveAll(one => !one.Thread.IsAlive);
            Runs.Add(run);
            run.Thread.Start();
            updated = false;
            StartCoroutine(SeeUpdate());
        }

        /// <summary>Goes on with the thread of a component that a change of scenes takes away.</summary>
        /// <param name="before">It has none afterwards.</param>
        /// <returns>False if its thread has ended.</returns>
        protected bool TakeThread(NetworkBehaviour before)
        {
            if (before.run == null || before.run.Stop.IsCancellationRequested || before.Done) return false;
            var taken = before.run;
            before.run = null;
            run = taken;
            run.Behaviour = this;
            return true;
        }

        /// <summary>Ends this client alone: the others note by themselves what the game's pause has interrupted.
        /// </summary>
        protected override void End()
        {
            if (run == null) return;
            run.Stop.Cancel();
            NetworkThread.Join(run.Thread);
        }

        // An Update of the reader's own may hide this one.
        private IEnumerator SeeUpdate()
        {
            yield return new WaitForSecondsRealtime(1);
            if (isActiveAndEnabled && Waiting && !updated)
                Debug.LogError($"{GetType().Name}: write its Update as protected override, with base.Update(); in it, "
                    + "or nothing that Talk logs or hands over is done");
        }

        /// <summary>Does what the network thread has for this frame.</summary>
        protected virtual void Update()
        {
            var end = Stopwatch.GetTimestamp() + BudgetTicks;
            for (var left = MostQueued; left > 0 && DoNext(0) && Stopwatch.GetTimestamp() < end; left--) { }
        }

        /// <summary>Does what the network thread has next for Update.</summary>
        /// <param name="timeout">For how many milliseconds to wait for it; a frame takes that much longer.</param>
        /// <returns>False if there is nothing.</returns>
        protected bool DoNext(int timeout)
        {
            updated = true;
            // One that could not begin has no run. And a listener may have disabled the component in this very frame:
            // it has heard enough.
            if (run == null || run.Stop.IsCancellationRequested) return false;
            if (!run.ForUpdate.TryTake(out var action, timeout)) return false;
            action();
            return true;
        }

        /// <summary>Tells the thread to end, and does not wait for that: a destroyed object must cost no
        /// frame.</summary>
        protected override void OnDisable() => run?.Stop.Cancel();

        /// <summary>Stop, and the end of the game: nothing may run on in the editor.</summary>
        protected virtual void OnApplicationQuit() => EndAll();

        // All are told before the first one is waited for: ten clients end in the time of one, 200 ms at the most.
        private static void EndAll()
        {
            foreach (var one in Runs) one.Stop.Cancel();
            foreach (var one in Runs) NetworkThread.Join(one.Thread);
            Runs.RemoveAll(one => !one.Thread.IsAlive);
        }

        /// <summary>One run of the thread. It never mixes with anything that a run before it has left behind.</summary>
        private sealed class Run
        {
            public readonly BlockingCollection<Action> ForUpdate = new BlockingCollection<Action>(MostQueued);
            public readonly CancellationTokenSource Stop = new CancellationTokenSource();
            public readonly Thread Thread, UnityThread = Thread.CurrentThread;
            // The component that owns the thread: a change of scenes may give it to another one. For the main thread.
            public NetworkBehaviour Behaviour;

            public Run(NetworkBehaviour behaviour)
            {
                Behaviour = behaviour;
                Thread = new Thread(() => Work(behaviour)) { IsBackground = true, Name = behaviour.GetType().Name };
            }

            private void Work(NetworkBehaviour behaviour)
            {
                own = this;
                // Without it the Profiler does not show a thread.
                Profiler.BeginThreadProfiling("NetMQ", Thread.Name);
                try
                {
                    behaviour.Talk(Stop.Token);
                }
                catch (ThreadAbortException) { /* The domain is being unloaded. */ }
                catch (Exception e)
                {
                    // After Stop nobody wants to know why it ended.
                    if (Stop.IsCancellationRequested) return;
                    var why = LogText.Why(e);
                    while (!ForUpdate.TryAdd(() => Behaviour.GiveUp(why), 50) && !Stop.IsCancellationRequested) { }
                }
            }
        }
    }
}
