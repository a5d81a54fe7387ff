// Lesson 13 in Unity, the example: parameters are drawn, statistics are recorded, and errors of the log go to Python.
//
// Use: start python/13_side_channels/server.py, add this component to any GameObject, press Play.
using System.Collections.Generic;
using System.Threading;
using UnityEngine;

namespace NetMQExample.MLAgents.SideChannels
{
    /// <summary>A number of rounds.</summary>
    [AddComponentMenu("NetMQ Example/13 Side Channel Client")]
    public sealed class SideChannelClient : SideChannelBehaviour
    {
        [SerializeField, Min(0), Tooltip("How many rounds")] private int count = 5;
        [SerializeField, Tooltip("What goes wrong: none, unknown, cut or throw")] private string trouble = "none";

        private SideChannelRounds rounds;

        protected override bool Over => rounds.Done;
        protected override bool GivesUp => true;

        protected override byte[] Exchange(List<byte[]> received) => rounds.Exchange(received);

        protected override void Begin()
        {
            // A phone begins again when the game is back.
            Forget();
            rounds = new SideChannelRounds(count, trouble, Timeout * 2, Debug.Log);
            Application.logMessageReceived += Forward;
            base.Begin();
        }

        protected override void OnDisable()
        {
            Forget();
            base.OnDisable();
        }

        protected override void Talk(CancellationToken stop)
        {
            base.Talk(stop);
            Log($"done: {count} rounds");
        }

        private void Forget()
        {
            Application.logMessageReceived -= Forward;
            rounds?.Dispose();
        }

        private void Forward(string text, string stack, LogType type)
        {
            if (type == LogType.Error || type == LogType.Exception)
                rounds.StringLog.SendDebugStatementToPython($"{type}: {text}\n{stack}");
        }
    }
}
