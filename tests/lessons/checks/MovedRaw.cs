// A channel as somebody has written it early in 2020, when a message was bytes: only `using` was changed.
using System;
using System.Collections.Generic;
using System.Text;
using NetMQExample.RawSideChannels;

namespace SomeOldGame
{
    public class OldLogChannel : SideChannel
    {
        public readonly List<string> Lines = new List<string>();

        public OldLogChannel()
        {
            ChannelId = new Guid("621f0a70-4f87-11ea-a6bf-784f4387d1f7");
        }

        public override void OnMessageReceived(byte[] data)
        {
            Lines.Add(Encoding.ASCII.GetString(data));
        }

        public void Send(string line)
        {
            QueueMessageToSend(Encoding.ASCII.GetBytes(line));
        }
    }
}
