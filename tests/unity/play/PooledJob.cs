// On a busy machine the last event of a disposed socket is at work when the domain is unloaded.
using System;
using System.Runtime.CompilerServices;
using System.Threading;
using UnityEngine;

namespace NetMQExample.PlayTest
{
    /// <summary>Leaves a job on the thread pool, which prints a line at its end.</summary>
    public sealed class PooledJob : MonoBehaviour
    {
        private void OnEnable() => RuntimeHelpers.RunClassConstructor(typeof(NetMQLifetime).TypeHandle);

        private void OnDestroy()
        {
            using var begun = new ManualResetEvent(false);
            ThreadPool.QueueUserWorkItem(_ =>
            {
                begun.Set();
                Thread.Sleep(100);
                Console.WriteLine("the job is done");
            });
            begun.WaitOne();
        }
    }
}
