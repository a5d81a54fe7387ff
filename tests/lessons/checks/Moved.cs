// Channels as somebody has written them for ML-Agents, today and early in 2020: only `using` was changed. Wherever a class
// says NetMQExample, Unity.MLAgents stood there before.
using System;
using System.Collections.Generic;
using NetMQExample;
using NetMQExample.SideChannels;
using UnityEngine;

namespace SomeGame
{
    public class GameLogChannel : SideChannel
    {
        public readonly List<string> Lines = new List<string>();

        public GameLogChannel()
        {
            ChannelId = new Guid("621f0a70-4f87-11ea-a6bf-784f4387d1f7");
        }

        protected override void OnMessageReceived(IncomingMessage msg)
        {
            var line = msg.ReadString();
            Lines.Add(line);
        }

        public void OnLog(string condition, string stackTrace, LogType type)
        {
            if (type != LogType.Error) return;
            using (var message = new OutgoingMessage())
            {
                message.WriteString(type.ToString() + ": " + condition + "\n" + stackTrace);
                QueueMessageToSend(message);
            }
        }
    }

    public class GameLogRegistration : MonoBehaviour
    {
        private GameLogChannel channel;

        public void Awake()
        {
            channel = new GameLogChannel();
            Application.logMessageReceived += channel.OnLog;
            SideChannelManager.RegisterSideChannel(channel);
        }

        public void OnDestroy()
        {
            Application.logMessageReceived -= channel.OnLog;
            if (Academy.IsInitialized) SideChannelManager.UnregisterSideChannel(channel);
        }
    }

    public class GameWorld
    {
        public float Gravity = 9.81f;

        private EnvironmentParameters parameters;
        private StatsRecorder statistics;

        public GameWorld()
        {
            parameters = Academy.Instance.EnvironmentParameters;
            statistics = Academy.Instance.StatsRecorder;
            parameters.RegisterCallback("gravity", value => Gravity = value);
        }

        public float Mass => parameters.GetWithDefault("mass", 1f);

        public void Score(float score)
        {
            statistics.Add("score", score);
            statistics.Add("scores", score, StatAggregationMethod.Histogram);
        }
    }
}
