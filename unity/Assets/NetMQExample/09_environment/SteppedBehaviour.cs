// Lesson 09 in Unity: what every scene shares that Python steps, be it one world or many.
//
// Physics is stepped by this component alone, and stands still while Python thinks. A frame serves Python for as long
// as it keeps asking, 30 ms at most; then Unity draws, and goes on at once: while Python steps there is no vSync and no
// target frame rate, unless Keep Frame Rate is ticked. A game that Python launches takes the endpoint from its command
// line, and quits when Python closes it, or ends.
using System;
using System.Collections.Generic;
using System.Runtime.ExceptionServices;
using System.Threading;
using UnityEngine;
using Stopwatch = System.Diagnostics.Stopwatch;

namespace NetMQExample
{
    /// <summary>A component with a simulator, which Python asks to step.</summary>
    public abstract class SteppedBehaviour : NetworkBehaviour
    {
        [SerializeField, Min(0), Tooltip("End after so many episodes; 0: when Python closes it")] private int count;
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait for an environment")] private float timeout = 30;
        [SerializeField, Tooltip("Leave vSync and target frame rate as they are while Python steps")]
        private bool keepFrameRate;

        // How many milliseconds a frame serves Python, and how long it waits when Python thinks for longer than that.
        private const int MostMilliseconds = 30, IdleMilliseconds = 10;

        // Physics and frames are everybody's: the first one that steps takes them, and the last one gives them back.
        private static readonly HashSet<SteppedBehaviour> Users = new HashSet<SteppedBehaviour>();
        private static readonly HashSet<SteppedBehaviour> Fast = new HashSet<SteppedBehaviour>();
        private static SimulationMode modeBefore;
        private static int vSyncBefore, rateBefore;

        private readonly Stopwatch clock = new Stopwatch(), thinking = new Stopwatch();
        private volatile Handover handover;

        /// <summary>The address of the environment.</summary>
        protected abstract string Endpoint { get; }

        /// <summary>Whether Python steps it; else it has no network thread.</summary>
        protected virtual bool Connects => true;

        /// <summary>The simulator that answers for this scene. Called on the network thread.</summary>
        protected abstract SimulatorBase MakeSimulator();

        protected override void Begin()
        {
            if (Users.Count == 0) modeBefore = Physics.simulationMode;
            Users.Add(this);
            Physics.simulationMode = SimulationMode.Script;
            // A new one each time: what a run before this one has asked for is over.
            handover = new Handover();
            if (Connects) base.Begin();
        }

        /// <summary>Goes on with what a component steps that a change of scenes takes away; false if that is over.
        /// The other one has nothing to do afterwards.</summary>
        protected bool GoOnWith(SteppedBehaviour before)
        {
            if (!TakeThread(before)) return false;
            handover = before.handover;
            Users.Remove(before);
            Users.Add(this);
            if (Fast.Remove(before)) Fast.Add(this);
            return true;
        }

        protected override void OnDisable()
        {
            if (Connects) base.OnDisable();
            Slow();
            if (Users.Remove(this) && Users.Count == 0) Physics.simulationMode = modeBefore;
        }

        protected override void Talk(CancellationToken stop)
        {
            var words = Environment.GetCommandLineArgs();
            var at = Array.IndexOf(words, "--endpoint") + 1;
            var place = at > 0 && at < words.Length ? words[at] : Endpoint;
            var own = handover;
            own.Launched = at > 0;
            Log($"asking {place}");
            var simulator = MakeSimulator();
            simulator.Mistake = Debug.LogException;
            own.Simulator = simulator;
            using var client = new EnvironmentClient(place, Seconds(timeout), Log);
            client.Run(simulator, count, work => Perform(own, simulator, work, stop), stop);
            Log($"done: {simulator.Episodes} episodes, {simulator.Steps} steps");
        }

        private void Perform(Handover own, SimulatorBase simulator, Action work, CancellationToken stop)
        {
            own.Quick = thinking.ElapsedMilliseconds < MostMilliseconds;
            own.Do(work, stop);
            // A hello, of which there is a new one each second while nobody listens, is no step.
            own.Stepped = simulator.Reply?.Kind != "hello";
            thinking.Restart();
        }

        protected override void Update()
        {
            if (Connects) Serve();
            if (Connects && handover.Stepped && !Done) Hurry();
            else Slow();
            // In the editor this does nothing. Not before the last line was logged.
            if (Connects && handover.Launched && Done) Application.Quit();
        }

        // A Python that thinks fast makes many steps in a frame; else, or when time is up, it goes on.
        private void Serve()
        {
            clock.Restart();
            do
            {
                // Log lines come before the step that follows them.
                while (DoNext(0)) { }
                var left = MostMilliseconds - (int)clock.ElapsedMilliseconds;
                var wait = handover.Quick ? left : handover.Stepped ? Math.Min(left, IdleMilliseconds) : 1;
                if (left <= 0 || !handover.DoNext(wait)) return;
            }
            while (isActiveAndEnabled && !handover.Simulator.Waiting);
        }

        private void Hurry()
        {
            if (keepFrameRate || Fast.Contains(this)) return;
            if (Fast.Count == 0) (vSyncBefore, rateBefore) = (QualitySettings.vSyncCount, Application.targetFrameRate);
            Fast.Add(this);
            QualitySettings.vSyncCount = 0;
            Application.targetFrameRate = -1;
        }

        private void Slow()
        {
            if (!Fast.Remove(this) || Fast.Count > 0) return;
            // A value that a script has set meanwhile stays.
            if (QualitySettings.vSyncCount == 0) QualitySettings.vSyncCount = vSyncBefore;
            if (Application.targetFrameRate == -1) Application.targetFrameRate = rateBefore;
        }
    }

    /// <summary>From the network thread to the main thread and back, without garbage.</summary>
    internal sealed class Handover
    {
        // Not a semaphore: it spins before it sleeps, and several games of one machine take each other's cores by that.
        private readonly object turn = new object();
        private Action work;
        private ExceptionDispatchInfo mistake;

        // The network thread's to set: whether Python thinks for less than a frame, steps, and has launched the game.
        public bool Quick { get; set; }

        public bool Stepped { get; set; }
        public bool Launched { get; set; }
        public SimulatorBase Simulator { get; set; }

        /// <summary>Has it done, and waits for that. For the network thread.</summary>
        public void Do(Action action, CancellationToken stop)
        {
            lock (turn)
            {
                mistake = null;
                work = action;
                Monitor.PulseAll(turn);
                while (work != null)
                    if (!Monitor.Wait(turn, 20)) stop.ThrowIfCancellationRequested();
                mistake?.Throw();
            }
        }

        /// <summary>Does what is asked for, within so many milliseconds. For the main thread.</summary>
        /// <returns>False if nothing was.</returns>
        public bool DoNext(int timeout)
        {
            lock (turn)
            {
                if (work == null && (timeout <= 0 || !Monitor.Wait(turn, timeout) || work == null)) return false;
                try { work(); }
                // It ends the thread that has asked for it, which reports it.
                catch (Exception e) { mistake = ExceptionDispatchInfo.Capture(e); }
                work = null;
                Monitor.PulseAll(turn);
                return true;
            }
        }
    }
}
