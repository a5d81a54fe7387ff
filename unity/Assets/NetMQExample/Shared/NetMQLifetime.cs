// What every NetMQ client in a process shares: one owner of NetMQ's process-wide state, and a Stop that does not
// freeze.
//
// NetMQ keeps one set of background threads per process. NetMQConfig.Cleanup() ends it, and with it every other
// client that is still talking; calling it never leaves two threads behind at each Play in Unity. So the users are
// counted, and the last one to leave cleans up.
using System;
using System.Globalization;
using System.IO;
using System.Text;
using System.Threading;
using AsyncIO;
using NetMQ;
using Stopwatch = System.Diagnostics.Stopwatch;

namespace NetMQExample
{
    /// <summary>
    /// One user of NetMQ's process-wide state. Make it on the network thread before the first socket and dispose it
    /// there after the last: <c>using var lifetime = new NetMQLifetime(); using var socket = new RequestSocket();</c>
    /// </summary>
    public sealed class NetMQLifetime : IDisposable
    {
        // NetMQ cleans up within milliseconds, or not at all; on a machine that is too busy for anything else within
        // seconds. Who leaves waits for less of that than who comes next, and could not begin before.
        private const int Leaving = 2000, Coming = 10000;
        private static readonly object Gate = new object();
        private static readonly Stopwatch Joining = new Stopwatch(), SinceJoin = new Stopwatch();
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
        // and now and then Mono itself ends. What Stop's 200 ms were too short for is waited for here; most often that
        // is nothing. On a machine that is too busy for anything else, more than five seconds were seen.
        private static void Unload(object domain, EventArgs nothing)
        {
            lock (Gate)
            {
                unloading = true;
                var waited = Stopwatch.StartNew();
                while ((Users > 0 || cleaning != null) && waited.ElapsedMilliseconds < Coming) Monitor.Wait(Gate, 50);
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
                if (!Cleaned(Coming))
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
                Cleaned(Leaving);
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
        private static bool Cleaned(int timeout)
        {
            while (cleaning != null)
            {
                var rest = timeout - cleaning.ElapsedMilliseconds;
                if (rest <= 0) return false;
                // It lets go of the lock meanwhile.
                Monitor.Wait(Gate, (int)rest);
            }
            return true;
        }

        /// <summary>Waits on Unity's main thread for a network thread that was asked to end. All the waits of one Stop
        /// share 200 ms, however many clients the scene has: Stop must never freeze the editor.</summary>
        /// <param name="thread">The thread; it may still run afterwards, and ends by itself.</param>
        public static void Join(Thread thread)
        {
            // A wait that begins a second after the one before belongs to another Stop.
            if (SinceJoin.ElapsedMilliseconds > 1000) Joining.Reset();
            Joining.Start();
            thread.Join(Math.Max(0, 200 - (int)Joining.ElapsedMilliseconds));
            Joining.Stop();
            SinceJoin.Restart();
        }

        /// <summary>What to show of an exception on the network thread. Those of this kit name cause and cure in one
        /// line; of all others the type and the stack are needed too, above all in a build on a device.</summary>
        /// <param name="e">The exception.</param>
        /// <returns>Its message, or everything that is known of it.</returns>
        public static string Why(Exception e) =>
            e is TimeoutException || e is ArgumentException || e is IOException || e is OperationCanceledException
                ? e.Message : e.ToString();

        /// <summary>What a peer sent, fit for one line of a log: no control characters, cut to a readable
        /// length.</summary>
        /// <param name="text">Whatever came.</param>
        /// <param name="most">What is a readable length.</param>
        /// <returns>At most so many characters and an ellipsis; a question mark for each one that cannot be
        /// shown.</returns>
        public static string Printable(string text, int most = 200)
        {
            var line = new StringBuilder();
            for (int at = 0, length = 0; text != null && at < text.Length; length++)
            {
                if (length == most) return line.Append('…').ToString();
                // What lies beyond the first 65,536 characters, such as an emoji, takes two chars.
                var width = char.IsSurrogatePair(text, at) ? 2 : 1;
                var kind = CharUnicodeInfo.GetUnicodeCategory(text, at);
                // Spaces, separators, controls, formats, halves of a pair and private use stand together in the enum.
                var hidden = kind >= UnicodeCategory.SpaceSeparator && kind <= UnicodeCategory.PrivateUse
                    || kind == UnicodeCategory.OtherNotAssigned;
                if (hidden && text[at] != ' ') line.Append('?');
                else line.Append(text, at, width);
                at += width;
            }
            return line.ToString();
        }
    }
}
