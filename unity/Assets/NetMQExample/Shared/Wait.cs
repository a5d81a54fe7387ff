// The time to wait, cut into slices: NetMQConnection.Slices, but without an object for each message.
using System;
using System.Diagnostics;
using System.Threading;

namespace NetMQExample
{
    /// <summary><c>for (var wait = new Wait(timeout, stop); wait.Next(out var slice);)</c></summary>
    internal struct Wait
    {
        private readonly TimeSpan timeout;
        private readonly CancellationToken stop;
        private readonly long start;
        private bool begun;

        public Wait(TimeSpan timeout, CancellationToken stop)
        {
            // Timeout.InfiniteTimeSpan is negative, and nothing here waits for ever.
            if (timeout < TimeSpan.Zero)
                throw new ArgumentException(FormattableString.Invariant(
                    $"timeout must be 0 s or more, not {timeout.TotalSeconds}"));
            this.timeout = timeout;
            this.stop = stop;
            start = Stopwatch.GetTimestamp();
            begun = false;
        }

        public bool Next(out TimeSpan slice)
        {
            var waited = (double)(Stopwatch.GetTimestamp() - start) / Stopwatch.Frequency;
            var most = NetMQConnection.Slice.TotalMilliseconds;
            var left = Math.Clamp(timeout.TotalMilliseconds - 1000 * waited, 0, most);
            // Whole ones: NetMQ waits for ever when it is asked to wait for less than a millisecond.
            slice = TimeSpan.FromMilliseconds((int)left);
            if (begun && left == 0) return false;
            begun = true;
            stop.ThrowIfCancellationRequested();
            return true;
        }
    }
}
