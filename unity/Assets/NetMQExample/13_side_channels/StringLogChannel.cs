// Lesson 13, a channel of your own: Python's lines come to Unity's log, and Unity's errors go to Python.
//
// ML-Agents' documentation has such a channel, with this id. The Python side is in server.py.
using System;

namespace NetMQExample.MLAgents.SideChannels
{
    /// <summary>Lines of text.</summary>
    public sealed class StringLogChannel : SideChannel
    {
        private readonly Action<string> log;
        private readonly bool throws;

        /// <summary>Gives each line that comes to <paramref name="log"/>, or throws on purpose.</summary>
        public StringLogChannel(Action<string> log, bool throws = false)
        {
            ChannelId = new Guid("621f0a70-4f87-11ea-a6bf-784f4387d1f7");
            this.log = Require.Given("log", log);
            this.throws = throws;
        }

        /// <summary>Queues a line. Not all of Unity's errors are ASCII.</summary>
        public void SendDebugStatementToPython(string text)
        {
            using var msg = new OutgoingMessage();
            msg.WriteString(text, utf8: true);
            QueueMessageToSend(msg);
        }

        protected override void OnMessageReceived(IncomingMessage msg)
        {
            if (throws) throw new UnityAgentsException("thrown on purpose");
            log($"From Python : {msg.ReadString("")}");
        }
    }
}
