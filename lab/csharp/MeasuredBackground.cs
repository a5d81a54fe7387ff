// Lesson 04's client costs the main thread this in each frame: a callback for each reply, and one request.
using System;
using UnityEngine;
using UnityPlayer;

namespace NetMQExample.Lab
{
    /// <summary>Logs the cost of a number of frames, as "measured: …".</summary>
    internal sealed class MeasuredBackground : MonoBehaviour
    {
        [SerializeField] private string endpoint = "tcp://127.0.0.1:5554";
        [SerializeField] private int frames = 1000;

        private BackgroundClient client;
        private FrameCost cost;
        // Made once: written at the call, they would be what is measured.
        private Action<string> onReply, onError;
        private int replies;

        public bool Done { get; private set; }

        private void OnEnable()
        {
            (onReply, onError, cost) = (_ => replies++, Fail, new FrameCost(frames));
            client = new BackgroundClient(endpoint);
        }

        private void Update()
        {
            if (Done) return;
            cost.Begin();
            client.Poll();
            client.Request("hello", onReply, onError);
            cost.End();
            if (!cost.Done) return;
            Done = true;
            Debug.Log($"measured: {replies} replies in {cost}");
        }

        private void OnDisable()
        {
            Done = true;
            client.Dispose();
        }

        private void Fail(string why)
        {
            if (Done) return;
            Done = true;
            Debug.LogError($"gave up: {why}");
        }
    }
}
