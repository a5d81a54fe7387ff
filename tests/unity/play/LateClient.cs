// On a busy machine a client's thread comes to its connection when the domain is being unloaded already.
using System;
using System.Runtime.CompilerServices;
using System.Threading;
using NetMQ.Sockets;
using UnityEngine;

namespace NetMQExample.PlayTest
{
    /// <summary>Connects in the midst of an assembly reload, which then aborts its thread: nobody disposes
    /// that.</summary>
    public sealed class LateClient : NetworkBehaviour
    {
        private static readonly ManualResetEvent Unloading = new ManualResetEvent(false),
            Tried = new ManualResetEvent(false);

        [SerializeField] private string endpoint = "tcp://127.0.0.1:5551";

        static LateClient()
        {
            // NetMQLifetime is told first that the domain is unloaded, and finds nobody to wait for.
            RuntimeHelpers.RunClassConstructor(typeof(NetMQLifetime).TypeHandle);
            AppDomain.CurrentDomain.DomainUnload += (domain, nothing) =>
            {
                Unloading.Set();
                Tried.WaitOne(5000);
            };
        }

        protected override void Talk(CancellationToken stop)
        {
            Log("asking");
            Unloading.WaitOne();
            try { _ = new NetMQConnection(endpoint, () => new RequestSocket()); }
            finally { Tried.Set(); }
            Thread.Sleep(Timeout.Infinite);
        }
    }
}
