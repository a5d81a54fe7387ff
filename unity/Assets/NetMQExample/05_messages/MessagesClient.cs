// Lesson 05 in Unity: an array and what it means go to Python from a thread of their own, and Update logs what comes
// back.
//
// Use: start python/05_messages/server.py, add this component to any GameObject, press Play.
using System;
using System.Threading;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Sends pictures to the server a number of times and logs where each is brightest.</summary>
    [AddComponentMenu("NetMQ Example/05 Messages Client")]
    public sealed class MessagesClient : NetworkBehaviour
    {
        [SerializeField, Tooltip("The server")] private string endpoint = "tcp://127.0.0.1:5555";
        [SerializeField, Min(0), Tooltip("How many pictures")] private int count = 10;
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait for each reply")] private float timeout = 2.5f;
        [SerializeField, Min(1), Tooltip("Times in a row to ask without a reply")] private int tries = 20;
        [SerializeField, Tooltip("With each reply")] private Arrival<Message> replied = new();

        public event Action<Message> Replied { add => replied.Raised += value; remove => replied.Raised -= value; }

        protected override void Talk(CancellationToken stop)
        {
            Log($"asking {endpoint}");
            using var requester = new MessageRequester(endpoint);
            for (int i = 1, lost = 0; i <= count;)
            {
                try
                {
                    var reply = requester.Request(TestPicture.Request(i), Seconds(timeout), stop);
                    Log(TestPicture.Line(i, reply));
                    Arrive(replied, reply);
                    i++;
                    lost = 0;
                }
                catch (TimeoutException e) when (++lost < tries)
                {
                    // To look at a picture twice does no harm. The next request has a new socket, and so finds a server
                    // that was started again.
                    Log($"trouble: {e.Message}");
                }
            }
            Log($"done: {count} replies");
        }
    }
}
