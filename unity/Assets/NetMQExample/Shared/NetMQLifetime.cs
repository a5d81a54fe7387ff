// All NetMQ clients of a process share one owner of NetMQ's process-wide state.
//
// NetMQ keeps one set of background threads per process. NetMQConfig.Cleanup() ends it, and with it every other
// client that is still talking; calling it never leaves two threads behind at each Play in Unity. So the users are
// counted, and the last one to leave cleans up.
using System;
using System.Threading;
using AsyncIO;
using NetMQ;
using Stopwatch = System.Diagnostics.Stopwatch;

namespace NetMQExample
{
    /// <summary>One user of NetMQ's process-wide state. Make it on the network thread before the first socket and
    /// dispose it there after the last: <c>using var lifetime = new NetMQLifetime(); using var socket = new
    /// RequestSocket();</c></summary>
    public sealed class NetMQLifetime : IDisposable
    {
        // NetMQ cleans up within milliseconds, or not at all; on a machine that is too busy for anything else within
        // seconds. A user that leaves waits for less of that than the next one that joins, which cannot begin before.
        private static readonly TimeSpan LeaveTimeout = TimeSpan.FromSeconds(2);
        private static readonly TimeSpan JoinTimeout = TimeSpan.FromSeconds(10);
        private static readonly object Gate = new object();
        private static bool unloading;
        private static Stopwatch cleaning;
        private bool left;

        static NetMQLifetime()
        {
            // Only Mono unloads a domain. In CoreCLR, to which Unity moves, the event never comes, and what listens to
            // it is never unloaded.
            if (Environment.Version.Major < 5) AppDomain.CurrentDomain.DomainUnload += Unload;
        }

        // An assembly reload aborts the threads of its domain. NetMQ's leave sockets open when that hits them at work,
        // and now and then Mono itself ends. Those that needed more than Stop's 200 ms are waited for here; most often
        // there are none. On a machine that is too busy for anything else, more than five seconds were seen.
        private static void Unload(object domain, EventArgs nothing)
        {
            lock (Gate)
            {
                unloading = true;
                var waited = Stopwatch.StartNew();
                while ((Users > 0 || cleaning != null) && waited.Elapsed < JoinTimeout) Monitor.Wait(Gate, 50);
            }
            // The last events of NetMQ's sockets come by the thread pool, a moment after they are disposed, and Mono
            // can end when it aborts one. Others may use the pool for longer, and are not waited for.
            ThreadPool.GetMaxThreads(out var all, out _);
            for (int rest = 200, free = 0; rest > 0 && free < all; rest--)
            {
                Thread.Sleep(1);
                ThreadPool.GetAvailableThreads(out free, out _);
            }
        }

        /// <summary>How many are there: each that was made and not disposed.</summary>
        public static int Users { get; private set; }

        /// <summary>Joins the users of NetMQ. The first one selects managed sockets on Windows.</summary>
        /// <exception cref="TimeoutException">NetMQ has not ended since the last user left.</exception>
        /// <exception cref="OperationCanceledException">An assembly reload has begun.</exception>
        public NetMQLifetime()
        {
            lock (Gate)
            {
                // Meanwhile older versions of NetMQ refuse a socket.
                if (!Cleaned(JoinTimeout))
                    throw new TimeoutException($"NetMQ has not ended for {cleaning.Elapsed.TotalSeconds:F0} s and "
                        + "cannot start again: dispose every socket; "
                        + "on macOS take NetMQ 4.0.4.5, those before 4.0.4.1 never end");
                // A thread that had no core until now, or has waited: it would be aborted with its sockets open.
                if (unloading) throw new OperationCanceledException("the scripts are being loaded anew");
                // On Windows NetMQ would use I/O completion ports, which outlive a domain reload in the Unity editor.
                // Elsewhere this call does nothing. It only counts before the first socket.
                if (Users++ == 0) ForceDotNet.Force();
            }
        }

        /// <summary>Leaves. The last user to leave ends NetMQ's background threads, and waits up to two seconds for
        /// them; if they do not end, the next user hears of it.</summary>
        public void Dispose()
        {
            lock (Gate)
            {
                if (left) return;
                left = true;
                // A thread that a domain reload aborts must not wait: NetMQ's own threads are aborted as well.
                var aborted = (Thread.CurrentThread.ThreadState & ThreadState.AbortRequested) != 0;
                if (--Users > 0 || aborted) return;
                cleaning = Stopwatch.StartNew();
                new Thread(Cleanup) { IsBackground = true, Name = "NetMQ cleanup" }.Start();
                Cleaned(LeaveTimeout);
            }
        }

        // On a thread of its own, and without the lock: nobody can tell how long it takes. It waits until the disposed
        // sockets are closed. Cleanup(false) does not, and their connections stay open until a garbage collection.
        private static void Cleanup()
        {
            try { NetMQConfig.Cleanup(); }
            finally
            {
                // Also where an assembly reload aborts this thread: whoever waits for it must not hold up the reload.
                lock (Gate)
                {
                    cleaning = null;
                    Monitor.PulseAll(Gate);
                }
            }
        }

        // Waits while NetMQ ends; false if it takes too long. The time counts from its beginning, so one that never
        // ends is waited for once.
        private static bool Cleaned(TimeSpan timeout)
        {
            while (cleaning != null)
            {
                var rest = timeout - cleaning.Elapsed;
                if (rest <= TimeSpan.Zero) return false;
                // It lets go of the lock meanwhile.
                Monitor.Wait(Gate, rest);
            }
            return true;
        }
    }
}
