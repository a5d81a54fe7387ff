// Lesson 13 in Unity: carries the side channels of a scene. They send and receive in Update.
//
// Use: start a Python program with a carrier, derive a component from this, add it to any GameObject, press Play:
// `public sealed class MyChannels : SideChannelBehaviour { }`. Register your channels whenever you like, on the main
// thread: `SideChannelManager.RegisterSideChannel(channel)`.
using System.Collections.Generic;
using System.Threading;
using UnityEngine;

namespace NetMQExample.MLAgents.SideChannels
{
    /// <summary>One connection for all channels of the scene.</summary>
    public abstract class SideChannelBehaviour : NetworkBehaviour
    {
        [SerializeField, Tooltip("The server")] private string endpoint = "tcp://127.0.0.1:5563";
        [SerializeField, Min(0.01f), Tooltip("Seconds that the server may be silent")] private float timeout = 5;

        // Whether what was packed before is still here.
        private bool full;

        protected System.TimeSpan Timeout => Seconds(timeout);

        /// <summary>True when there is nothing more to say.</summary>
        protected virtual bool Over => false;

        /// <summary>Whether it ends when the server was silent for so long. Else it says so, and goes on
        /// trying.</summary>
        protected virtual bool GivesUp => false;

        /// <summary>Hands the received exchanges to the channels, and returns the one that they have queued.</summary>
        protected virtual byte[] Exchange(List<byte[]> received)
        {
            SideChannelManager.Receive(received);
            return full ? new byte[0] : SideChannelManager.GetSideChannelMessage();
        }

        protected override void Begin()
        {
            SideChannelManager.Report = new Trouble(Debug.LogWarning).Report;
            Academy.Instance.Begin(EngineSettings.Apply);
            base.Begin();
        }

        protected override void OnDisable()
        {
            base.OnDisable();
            if (Academy.IsInitialized) Academy.Instance.Dispose();
        }

        protected override void Talk(CancellationToken stop)
        {
            Log($"asking {endpoint}");
            using var carrier = new SideChannelCarrier(endpoint, Timeout, GivesUp ? (System.Action<string>)null : Log);
            for (var data = new byte[0]; !Over;)
            {
                var received = carrier.Exchange(data, NetMQConnection.Slice, stop);
                full = carrier.Full;
                data = FromUpdate(() => Exchange(received));
            }
        }
    }
}
