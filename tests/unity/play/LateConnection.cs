// What a busy machine does to a WebSocket that is let go at once: its turn on the thread pool comes in the midst of an
// assembly reload.
using System;
using System.Threading;
using UnityEngine;

namespace NetMQExample.PlayTest
{
    /// <summary>Leaves a connection that has not begun yet, and prints whether it has ended before the reload.</summary>
    public sealed class LateConnection : MonoBehaviour
    {
        private void OnDestroy()
        {
            for (var i = 0; i < 4 * Environment.ProcessorCount; i++)
                ThreadPool.QueueUserWorkItem(_ => Thread.Sleep(20));
            var connection = new DotNetConnection("ws://127.0.0.1:9");
            connection.Dispose();
            AppDomain.CurrentDomain.DomainUnload += (domain, nothing) =>
                Console.WriteLine($"the connection has ended: {connection.Closed != null}");
        }
    }
}
