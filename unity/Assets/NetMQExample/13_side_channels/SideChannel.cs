// Lesson 13, side channels: many small conversations share one exchange, and none knows the others.
//
//     public class StringLogChannel : SideChannel …
//     SideChannelManager.RegisterSideChannel(new StringLogChannel());
//
// The names are ML-Agents': a channel class that was written for it works here, with `using NetMQExample.SideChannels`
// in place of `using Unity.MLAgents.SideChannels`. The Python side is side_channel.py.
// Take home: this file, SideChannelMessages.cs and SideChannelManager.cs.
using System;
using System.Collections.Generic;

namespace NetMQExample.SideChannels
{
    /// <summary>One conversation. Derive from it, and give it an id that no other has.</summary>
    public abstract class SideChannel
    {
        // An exchange is at most this large, with the 20 bytes in front of each message.
        internal const int LargestExchange = 16 * 1024 * 1024;

        /// <summary>The same on both sides; set it in the constructor.</summary>
        public Guid ChannelId { get; protected set; }

        internal Queue<byte[]> MessageQueue { get; } = new Queue<byte[]>();

        internal virtual void ProcessMessage(byte[] message)
        {
            using var incoming = new IncomingMessage(message);
            OnMessageReceived(incoming);
        }

        internal void QueueBytes(byte[] data)
        {
            if (data.Length > LargestExchange - 20)
                throw new UnityAgentsException($"a message of {data.Length} bytes is too large: send it in parts");
            MessageQueue.Enqueue(data);
        }

        /// <summary>A message of the other side's channel with the same id.</summary>
        protected abstract void OnMessageReceived(IncomingMessage msg);

        /// <summary>It leaves with the next exchange.</summary>
        protected void QueueMessageToSend(OutgoingMessage msg) => QueueBytes(msg.ToByteArray());
    }
}
