// Lesson 13, raw bytes: messages, such as pictures, to which you give a meaning yourself. Both ways.
//
// The Python side is raw_bytes_channel.py.
using System;
using System.Collections.Generic;

namespace NetMQExample.MLAgents.SideChannels
{
    /// <summary>Messages as they are.</summary>
    public class RawBytesChannel : SideChannel
    {
        private List<byte[]> received = new List<byte[]>();

        /// <summary>With an id of yours.</summary>
        public RawBytesChannel(Guid channelId) => ChannelId = channelId;

        public void SendRawBytes(byte[] data)
        {
            using var msg = new OutgoingMessage();
            msg.SetRawBytes(data);
            QueueMessageToSend(msg);
        }

        /// <summary>Those that have come, and are forgotten here.</summary>
        public IList<byte[]> GetAndClearReceivedMessages()
        {
            var messages = received;
            received = new List<byte[]>();
            return messages;
        }

        public IList<byte[]> GetReceivedMessages() => received.AsReadOnly();
        protected override void OnMessageReceived(IncomingMessage msg) => received.Add(msg.GetRawBytes());
    }
}
