// Lesson 13, statistics: numbers that Unity wants to see beside the trainer's own. From Unity to Python.
//
//     Academy.Instance.StatsRecorder.Add("score", 12.5f, StatAggregationMethod.Histogram);
//
// Bytes: string key, float32 value, int32 how to aggregate. The Python side is stats_side_channel.py.
using System;
using NetMQExample.MLAgents.SideChannels;

namespace NetMQExample.MLAgents
{
    /// <summary>How to combine the values of one key.</summary>
    public enum StatAggregationMethod
    {
        Average = 0,
        /// <summary>The last one.</summary>
        MostRecent = 1,
        Sum = 2,
        Histogram = 3,
    }

    /// <summary>Sends what the trainer is to show.</summary>
    public sealed class StatsRecorder : SideChannel
    {
        public StatsRecorder() => ChannelId = new Guid("a1d8f7b7-cec8-50f9-b78b-d3e165a78520");

        public void Add(
            string key, float value, StatAggregationMethod aggregationMethod = StatAggregationMethod.Average)
        {
            using var msg = new OutgoingMessage();
            msg.WriteString(key);
            msg.WriteFloat32(value);
            msg.WriteInt32((int)aggregationMethod);
            QueueMessageToSend(msg);
        }

        protected override void OnMessageReceived(IncomingMessage msg) =>
            throw new UnityAgentsException("statistics came from Python, which is to receive them");
    }
}
