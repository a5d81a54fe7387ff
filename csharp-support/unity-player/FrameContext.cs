// The code after an await on Unity's main thread runs there again, in the frame after.
using System;
using System.Collections.Concurrent;
using System.Threading;
using UnityEngine;

namespace UnityPlayer
{
    internal sealed class FrameContext : SynchronizationContext
    {
        private readonly ConcurrentQueue<(SendOrPostCallback Call, object State)> queue =
            new ConcurrentQueue<(SendOrPostCallback, object)>();

        public override void Post(SendOrPostCallback d, object state) => queue.Enqueue((d, state));
        public override SynchronizationContext CreateCopy() => this;

        public void Run()
        {
            // Only what is there now: a continuation that posts itself again waits for the next frame.
            for (var left = queue.Count; left > 0 && queue.TryDequeue(out var item); left--)
                try { item.Call(item.State); }
                catch (Exception e) { Debug.LogException(e); }
        }
    }
}
