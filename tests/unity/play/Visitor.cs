// A game that asks for itself, from far away, comes near, asks something else in the middle, and walks away.
using UnityEngine;

namespace NetMQExample.PlayTest
{
    /// <summary>Its next question ends the one before.</summary>
    public sealed class Visitor : TalkingCharacter
    {
        private readonly string[] questions = { "What is your name?", "Who are you?", "Who built this bridge?" };
        private Transform eyes;
        private int frames, asked;

        private void Start() => Ended += text => Debug.Log($"ended {text}");

        protected override void Update()
        {
            if (eyes == null)
            {
                eyes = new GameObject("player") { tag = "MainCamera" }.AddComponent<Camera>().transform;
                eyes.position = new Vector3(0, 0, 16);
            }
            base.Update();
            if (++frames == 30)
            {
                Debug.Log("comes near");
                eyes.position = new Vector3(0, 0, 14);
            }
            if (asked < 3 && (asked == 0 || Text.Contains(questions[asked - 1])))
            {
                if (asked > 0) Debug.Log($"heard {Text}");
                Ask(questions[asked++]);
            }
            if (asked == 3 && Text.Contains("plank!")) eyes.position = new Vector3(0, 0, 16);
        }

        protected override void OnGUI() { }
    }
}
