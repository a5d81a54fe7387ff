// What follows an await on Unity's main thread runs there again, in the frame after.
using System;
using System.Collections.Concurrent;
using System.Threading;
using UnityEngine;

namespace UnityPlayer
{
    internal sealed class FrameContext : SynchronizationContext
    {
        private readonly Thread main = Thread.CurrentThread;
        private readonly ConcurrentQueue<(SendOrPostCallback Call, object State)> queue = new ConcurrentQueue<(SendOrPostCallback, object)>();

        public override void Post(SendOrPostCallback d, object state) => queue.Enqueue((d, state));

        public override void Send(SendOrPostCallback d, object state)
        {
            if (main == Thread.CurrentThread)
            {
                d(state);
                return;
            }
            using var done = new ManualResetEventSlim();
            Post(_ =>
            {
                try
                {
                    d(state);
                }
                finally
                {
                    done.Set();
                }
            }, null);
            done.Wait();
        }

        public override SynchronizationContext CreateCopy() => this;

        public void Run()
        {
            // Only what is there now: a continuation that posts itself again waits for the next frame.
            for (var left = queue.Count; left > 0 && queue.TryDequeue(out var item); left--)
                try
                {
                    item.Call(item.State);
                }
                catch (Exception e)
                {
                    Debug.LogException(e);
                }
        }
    }
}
