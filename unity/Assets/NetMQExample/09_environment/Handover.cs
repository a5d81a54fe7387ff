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

        /// <summary>Whether Python thinks for less than a frame. The network thread sets this, and what follows.
        /// </summary>
        public bool Quick { get; set; }

        /// <summary>Whether it steps.</summary>
        public bool Stepped { get; set; }

        /// <summary>Whether it has launched the game.</summary>
        public bool Launched { get; set; }

        /// <summary>What is asked.</summary>
        public SimulatorBase Simulator { get; set; }

        /// <summary>Has it done, and waits for that. For the network thread.</summary>
        /// <param name="action">It may touch the scene.</param>
        /// <param name="stop">Ends the wait.</param>
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

        /// <summary>Does what is asked for. For the main thread.</summary>
        /// <param name="timeout">How many milliseconds to wait for it.</param>
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
