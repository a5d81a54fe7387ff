// On a busy machine a WebSocket is let go at once, and the turns of what it does on the thread pool come in
// the midst of an assembly reload.
using System;
using System.Reflection;
using System.Threading;
using System.Threading.Tasks;
using UnityEngine;

namespace NetMQExample.PlayTest
{
    /// <summary>Leaves a connection that has not begun yet, and prints whether all of it ends before the
    /// reload.</summary>
    public sealed class LateConnection : MonoBehaviour
    {
        private void OnDestroy()
        {
            FillPool(20);
            var connection = new DotNetConnection("ws://127.0.0.1:9");
            FillPool(200);
            connection.Send("Hello");
            connection.Dispose();
            var field = typeof(DotNetConnection).GetField("sending", BindingFlags.NonPublic | BindingFlags.Instance);
            var sending = (Task)field.GetValue(connection);
            AppDomain.CurrentDomain.DomainUnload += (domain, nothing) => Console.WriteLine(
                $"the connection has ended: {connection.Closed != null}, and what it sends: {sending.IsCompleted}");
        }

        private static void FillPool(int milliseconds)
        {
            for (var i = 0; i < 4 * Environment.ProcessorCount; i++)
                ThreadPool.QueueUserWorkItem(_ => Thread.Sleep(milliseconds));
        }
    }
}
