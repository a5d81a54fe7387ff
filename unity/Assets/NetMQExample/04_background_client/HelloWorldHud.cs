// A head-up display for lesson 04: what a BackgroundClient knows, in the corner of the game's view; when it is done, a
// line in the log says how many frames there were and how long the longest took.
// A headset shows nothing that is drawn there: with a TextMesh (Component, Mesh) on the same GameObject it
// stands in the scene.
//
// Use: add it to the GameObject with HelloBackground. For a component of your own, write its name in place of that one,
// and let it have a property Client.
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Shows state, round-trip time, messages a second and the last error.</summary>
    [AddComponentMenu("NetMQ Example/04 Hello World Hud")]
    [RequireComponent(typeof(HelloBackground))]
    public sealed class HelloWorldHud : MonoBehaviour
    {
        // A text is garbage once it is drawn: twice a second is often enough to read, and too rare to matter.
        private const float IntervalSeconds = 0.5f;

        private HelloBackground source;
        private BackgroundClient client;
        private TextMesh mesh;
        private float next, before, longest;
        private int repliesBefore, frames;
        private bool done;

        /// <summary>The text in the corner of the game.</summary>
        public string Text { get; private set; } = "";

        private void OnEnable()
        {
            // IMGUI's own layout would cost a pass, and garbage, in each frame.
            useGUILayout = false;
            source = GetComponent<HelloBackground>();
            mesh = GetComponent<TextMesh>();
        }

        private void Update()
        {
            // Time.deltaTime never says more than Time.maximumDeltaTime, a third of a second.
            if (frames > 0 && !done) longest = System.Math.Max(longest, Time.unscaledDeltaTime);
            frames++;
            if (source.Done && !done) Debug.Log($"frames: {frames}, the longest took {longest * 1000:F0} ms");
            done = source.Done;
            var now = Time.realtimeSinceStartup;
            if (source.Client == null || now < next) return;
            if (client != source.Client)
            {
                client = source.Client;
                before = now;
                repliesBefore = 0;
            }
            // A client that was made just now has no rate yet.
            var rate = now > before ? (client.Replies - repliesBefore) / (now - before) : 0;
            Text = $"{client.State}\nround trip {client.RoundTripTime.TotalMilliseconds:F1} ms\n"
                + $"{rate:F0} messages a second\n{client.LastError}";
            next = now + IntervalSeconds;
            before = now;
            repliesBefore = client.Replies;
            if (mesh != null) mesh.text = Text;
        }

        private void OnGUI()
        {
            if (mesh == null) GUI.Label(new Rect(10, 10, 800, 100), Text);
        }
    }
}
