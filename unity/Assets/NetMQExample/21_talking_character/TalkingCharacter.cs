// Application 21 in Unity: a character answers while its words are made. It begins when the player is near, and stops
// when the player walks away, or the component is disabled.
//
// Use: start python/21_talking_character/server.py, add this component to a character, press Play. Then, from the game:
// `character.Ask("Who are you?")`.
using System;
using System.Threading;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Says what a model answers, in the corner of the game's view and in the console.</summary>
    [AddComponentMenu("NetMQ Example/21 Talking Character")]
    public class TalkingCharacter : NetworkBehaviour
    {
        [SerializeField, Tooltip("The server")] private string endpoint = "tcp://127.0.0.1:5571";
        [SerializeField, Tooltip("What the player says")] private string prompt = "Who built this bridge?";
        [SerializeField, Min(1), Tooltip("How many words to listen to at most")] private int count = 200;
        /// <summary>The listener; the main camera until it is set.</summary>
        [Tooltip("Who listens; none: the main camera")] public Transform player;
        [SerializeField, Min(0), Tooltip("How near one must be to listen")] private float earshot = 15;
        [SerializeField, Min(0), Tooltip("Walk away when so many words were said; 0: never")] private int leaveAfter;
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait for a word of the job")] private float timeout = 1;
        [SerializeField, Min(1), Tooltip("How often to connect anew")] private int tries = 5;
        [SerializeField, Tooltip("With each sentence")] private Arrival<string> said = new();
        [SerializeField, Tooltip("With all that it has said, at its end")] private Arrival<string> ended = new();

        private volatile bool near;
        private volatile string text = "";
        private volatile JobClient client;
        // Whether it has said so.
        private bool over;

        /// <summary>All that was said so far, for a bubble of your own.</summary>
        public string Text => text;

        public event Action<string> Said { add => said.Raised += value; remove => said.Raised -= value; }

        /// <summary>At the end of what it says, however that came, with all of it; but not where another Ask, or who
        /// disables it, breaks it off. LastError says what went wrong.</summary>
        public event Action<string> Ended { add => ended.Raised += value; remove => ended.Raised -= value; }

        /// <summary>Says something else to it, at once; what it is saying breaks off.</summary>
        public void Ask(string words)
        {
            enabled = false;
            (prompt, text, over) = (words, "", false);
            enabled = true;
        }

        /// <summary>As if the player went out of earshot.</summary>
        public void WalkAway() => client?.Cancel();

        // IMGUI's own layout would cost a pass, and garbage, in each frame.
        private void Awake() => useGUILayout = false;

        protected override void Update()
        {
            base.Update();
            var ends = Done && !over;
            over = Done;
            if (ends) ended.Raise(text);
            if (player == null && Camera.main != null) player = Camera.main.transform;
            near = player == null || Vector3.Distance(player.position, transform.position) <= earshot;
            if (!near) WalkAway();
        }

        /// <summary>Draws the text; override it where the game has a place of its own for that.</summary>
        protected virtual void OnGUI() => GUI.Label(new Rect(10, 10, 600, 300), text);

        protected override void Talk(CancellationToken stop)
        {
            while (!near) if (stop.WaitHandle.WaitOne(20)) return;
            var speech = new Speech();
            using var mine = client = new JobClient(endpoint, JobClient.NewId(), Seconds(timeout), tries, Log);
            Log($"asking {endpoint}: {LogText.Printable(prompt)}");
            foreach (var news in mine.Watch(Speech.Ask(mine, prompt, count), Speech.LeaveAt(mine, stop)))
            {
                // The next one may speak already.
                if (stop.IsCancellationRequested) continue;
                var sentences = speech.Sentences(news);
                text = speech.Text;
                foreach (var sentence in sentences)
                {
                    Log($"she: {sentence}");
                    Arrive(said, sentence);
                }
                if (news.Kind == "feedback" && leaveAfter > 0 && speech.Words >= leaveAfter) mine.Cancel();
            }
            Log(speech.Outcome());
        }
    }
}
