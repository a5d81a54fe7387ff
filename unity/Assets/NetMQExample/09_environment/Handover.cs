// Lesson 09 in Unity: one thing after the other is done on the main thread, while the network thread waits for it.
using System;
using System.Runtime.ExceptionServices;
using System.Threading;

namespace NetMQExample
{
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
