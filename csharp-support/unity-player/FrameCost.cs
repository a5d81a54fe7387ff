// The cost of a part of each frame: its time, and the garbage that it leaves.
using System;
using System.Diagnostics;

namespace UnityPlayer
{
    /// <summary>Call <see cref="Begin"/> and <see cref="End"/> around the part, in each frame.</summary>
    public sealed class FrameCost
    {
        // In the first frames code is compiled and queues grow. Only the cost that goes on for hours counts.
        private const int WarmUp = 100;
        private static readonly bool Counted = CountsBytes();
        private readonly double[] milliseconds;
        private int frame = -WarmUp, dirty;
        private long allocatedBefore, allocated, start;

        /// <summary>Sets the number of frames to measure.</summary>
        /// <param name="frames">How many, after 100 that do not count.</param>
        public FrameCost(int frames) => milliseconds = new double[frames];

        /// <summary>True once all frames were measured.</summary>
        public bool Done => frame >= milliseconds.Length;

        /// <summary>The part begins.</summary>
        public void Begin()
        {
            allocatedBefore = GC.GetAllocatedBytesForCurrentThread();
            start = Stopwatch.GetTimestamp();
        }

        /// <summary>The part has ended.</summary>
        /// <param name="without">Milliseconds of it that do not count.</param>
        public void End(double without = 0)
        {
            var took = (Stopwatch.GetTimestamp() - start) * 1000.0 / Stopwatch.Frequency - without;
            var bytes = GC.GetAllocatedBytesForCurrentThread() - allocatedBefore;
            if (frame >= 0 && !Done)
            {
                milliseconds[frame] = took;
                allocated += bytes;
                if (bytes > 0) dirty++;
            }
            frame++;
        }

        /// <summary>The result, in one line.</summary>
        /// <returns>Frames, mean, median, 99th percentile and longest time, and the bytes allocated.</returns>
        public override string ToString()
        {
            var sorted = (double[])milliseconds.Clone();
            Array.Sort(sorted);
            var sum = 0.0;
            foreach (var time in sorted) sum += time;
            string Below(double share) =>
                FormattableString.Invariant($"{sorted[(int)(share * (sorted.Length - 1))]:F4} ms");
            return FormattableString.Invariant($"{sorted.Length} frames: mean {sum / sorted.Length:F4} ms, ")
                + $"half below {Below(0.5)}, 99 of 100 below {Below(0.99)}, longest {Below(1)}, "
                + (Counted
                    ? $"{allocated} bytes allocated in {dirty} frames"
                    : "bytes are not counted by this runtime");
        }

        // The garbage collector of Unity's Mono and of IL2CPP says 0 whatever was allocated; there the Profiler window
        // of the editor has it, as GC Allocated In Frame.
        private static bool CountsBytes()
        {
            var before = GC.GetAllocatedBytesForCurrentThread();
            GC.KeepAlive(new byte[100_000]);
            return GC.GetAllocatedBytesForCurrentThread() - before >= 100_000;
        }
    }
}
