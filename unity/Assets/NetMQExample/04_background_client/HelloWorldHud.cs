// A head-up display for lesson 04: what a BackgroundClient knows, in the corner of the game's view.
//
// Use: add it to the GameObject with HelloBackground. For a component of your own, write its name in place of that one, and
// let it have a property Client.
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Shows state, round-trip time, messages a second and the last error.</summary>
    [RequireComponent(typeof(HelloBackground))]
    public sealed class HelloWorldHud : MonoBehaviour
    {
        // A text is garbage once it is drawn: twice a second is often enough to read, and too rare to matter.
        private const float Interval = 0.5f;

        private HelloBackground source;
        private float next, before;
        private int repliesBefore;

        /// <summary>What is drawn.</summary>
        public string Text { get; private set; } = "";

        private void OnEnable() => source = GetComponent<HelloBackground>();

        private void Update()
        {
            var now = Time.realtimeSinceStartup;
            var client = source.Client;
            if (client == null || now < next) return;
            var rate = (client.Replies - repliesBefore) / (now - before);
            Text = $"{client.State}\nround trip {client.RoundTripTime.TotalMilliseconds:F1} ms\n"
                + $"{rate:F0} messages a second\n{client.LastError}";
            (next, before, repliesBefore) = (now + Interval, now, client.Replies);
        }

        private void OnGUI() => GUI.Label(new Rect(10, 10, 800, 100), Text);
    }
}
