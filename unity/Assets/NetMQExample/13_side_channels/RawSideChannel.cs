// Lesson 13, the raw layout: channels as ML-Agents had them early in 2020, where a message was bytes and nothing else.
//
// The exchange is the same, and such a channel talks to any other. Only a text had no length in front of it then: it
// was the whole message. A class from that time says `using NetMQExample.RawSideChannels`.
using NetMQExample.MLAgents.SideChannels;

namespace NetMQExample.RawSideChannels
{
    /// <summary>One conversation in bytes.</summary>
    public abstract class SideChannel : NetMQExample.MLAgents.SideChannels.SideChannel
    {
        internal override void ProcessMessage(byte[] message) => OnMessageReceived(message);

        public abstract void OnMessageReceived(byte[] data);

        protected sealed override void OnMessageReceived(IncomingMessage msg) => OnMessageReceived(msg.GetRawBytes());

        /// <summary>It leaves with the next exchange.</summary>
        protected void QueueMessageToSend(byte[] data) => QueueBytes((byte[])data.Clone());
    }
}
