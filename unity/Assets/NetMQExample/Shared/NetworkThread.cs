// How Unity's main thread waits for network threads that were asked to end.
using System;
using System.Diagnostics;
using System.Threading;

namespace NetMQExample
{
    /// <summary>The end of a network thread. For the main thread alone.</summary>
    public static class NetworkThread
    {
        private const int LimitMilliseconds = 200;
        private static readonly Stopwatch Joining = new Stopwatch(), SinceJoin = new Stopwatch();

        /// <summary>Waits for a thread. All the waits of one Stop share 200 ms, however many clients the scene has:
        /// Stop must never freeze the editor.</summary>
        /// <param name="thread">The thread; it may still run afterwards, and ends by itself.</param>
        public static void Join(Thread thread)
        {
            // A wait that begins a second after the one before belongs to another Stop.
            if (SinceJoin.ElapsedMilliseconds > 1000) Joining.Reset();
            Joining.Start();
            thread.Join(Math.Max(0, LimitMilliseconds - (int)Joining.ElapsedMilliseconds));
            Joining.Stop();
            SinceJoin.Restart();
        }
    }
}
