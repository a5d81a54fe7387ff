// Threads tell the Profiler their names.
using System.Collections.Concurrent;

namespace UnityEngine.Profiling
{
    public sealed class Profiler
    {
        /// <summary>Which there are: group and name.</summary>
        internal static ConcurrentQueue<string> Threads { get; } = new ConcurrentQueue<string>();

        public static void BeginThreadProfiling(string threadGroupName, string threadName) =>
            Threads.Enqueue($"{threadGroupName}: {threadName}");
    }
}
