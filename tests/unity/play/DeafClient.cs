// A client that is busy with something else when it is told to end.
using System.Threading;
using UnityEngine;

namespace NetMQExample.PlayTest
{
    /// <summary>Ends two seconds after it began, whatever it is told.</summary>
    public sealed class DeafClient : NetworkBehaviour
    {
        [SerializeField] private string endpoint = "tcp://127.0.0.1:5551";

        protected override void Talk(CancellationToken stop)
        {
            Log($"asking {endpoint}");
            Thread.Sleep(2000);
        }
    }
}
