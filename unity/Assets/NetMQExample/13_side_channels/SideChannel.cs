// Lesson 13, side channels: many small conversations share one exchange, and none knows the others.
//
//     public class StringLogChannel : SideChannel …
//     SideChannelManager.RegisterSideChannel(new StringLogChannel());
//
// The names are ML-Agents': a channel class that was written for it works here, with
// `using NetMQExample.MLAgents.SideChannels` in place of `using Unity.MLAgents.SideChannels`. The Python side is
// side_channel.py.
using System;
using System.Collections.Generic;

namespace NetMQExample.MLAgents.SideChannels
{
    /// <summary>One conversation. Derive from it, and give it an id that no other has.</summary>
    public abstract class SideChannel
    {
        // An exchange is at most this large, with the 20 bytes in front of each message.
        internal const int LargestExchangeBytes = 16 * 1024 * 1024;

        // A channel keeps so much while no reader takes its messages.
        private const int MostQueuedMessages = 100_000;
        private const long MostQueuedBytes = 4L * LargestExchangeBytes;

        private readonly Queue<byte[]> queue = new Queue<byte[]>();
        private long bytes, dropped;

        /// <summary>The same on both sides; set it in the constructor.</summary>
        public Guid ChannelId { get; protected set; }

        // Whether there is anything to send, or to say about what was dropped.
        internal bool HasMore => queue.Count > 0 || dropped > 0;

        internal virtual void ProcessMessage(byte[] message)
        {
            using var incoming = new IncomingMessage(message);
            OnMessageReceived(incoming);
        }

        internal void QueueBytes(byte[] data)
        {
            if (data.Length > LargestExchangeBytes - 20)
                throw new UnityAgentsException($"a message of {data.Length} bytes is too large: send it in parts");
            queue.Enqueue(data);
            bytes += data.Length;
            if (queue.Count <= MostQueuedMessages && bytes <= MostQueuedBytes) return;
            if (dropped == 0)
                SideChannelManager.Report($"channel {ChannelId}: nobody takes its messages, the oldest are dropped");
            for (var left = queue.Count / 2; queue.Count > left; dropped++) bytes -= queue.Dequeue().Length;
        }

        // The next one, if there is room for it and the 20 bytes in front of it.
        internal bool TryTake(long room, out byte[] message)
        {
            if (dropped > 0) SideChannelManager.Report($"channel {ChannelId}: {dropped} messages were dropped");
            dropped = 0;
            if (!queue.TryPeek(out message) || 20 + message.Length > room) return false;
            bytes -= queue.Dequeue().Length;
            return true;
        }

        protected abstract void OnMessageReceived(IncomingMessage msg);

        /// <summary>It leaves with the next exchange.</summary>
        protected void QueueMessageToSend(OutgoingMessage msg)
        {
            // No exception: in ML-Agents there is none, and it would come out of whatever the game is doing.
            if (msg.Refused != null) SideChannelManager.Report($"channel {ChannelId}: not sent, {msg.Refused}");
            else QueueBytes(msg.ToByteArray());
        }
    }
}
