// Lesson 09 in Unity: one thing after the other is done on the main thread, while the network thread waits for it.
using System;
using System.Runtime.ExceptionServices;
using System.Threading;

namespace NetMQExample
{
    /// <summary>From the network thread to the main thread and back, without garbage.</summary>
    internal sealed class Handover
    {
        private readonly SemaphoreSlim asked = new SemaphoreSlim(0), done = new SemaphoreSlim(0);
        private Action work;
        private ExceptionDispatchInfo mistake;

        /// <summary>Has it done, and waits for that. For the network thread.</summary>
        /// <param name="action">What may touch the scene.</param>
        /// <param name="stop">Ends the wait.</param>
        public void Do(Action action, CancellationToken stop)
        {
            work = action;
            mistake = null;
            asked.Release();
            // In slices, and not with the token: its callback would be garbage.
            while (!done.Wait(20)) stop.ThrowIfCancellationRequested();
            mistake?.Throw();
        }

        /// <summary>Does what is asked for. For the main thread.</summary>
        /// <param name="timeout">How many milliseconds to wait for it.</param>
        /// <returns>False if nothing was.</returns>
        public bool DoNext(int timeout)
        {
            if (!asked.Wait(timeout)) return false;
            try { work(); }
            // Whoever has asked for it ends by it, and says so.
            catch (Exception e) { mistake = ExceptionDispatchInfo.Capture(e); }
            finally { done.Release(); }
            return true;
        }
    }
}
