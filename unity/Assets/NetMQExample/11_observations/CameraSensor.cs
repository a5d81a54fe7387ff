// Lesson 11 in Unity, a camera as a sensor: what it sees goes with the observation of the agents above it.
//
// Use: put it on a game object somewhere below an agent's, with the camera. Without a locator the key is the names of
// the game objects between the agent and this one; on the agent's own it is "camera". With one, such as ".eye", that
// stands behind them; "@.eye" begins at the agent's root.
// The picture is uint8 [height, width, 3], or [height, width] in grey, the highest row first.
// Take home: this file and CameraView.cs, with Agent.cs and what that needs.
// Trouble: each answer waits for its pictures, and the main thread with it. That is what lock-step means.
using System;
using System.Collections.Generic;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>A picture for each answer to Python.</summary>
    public sealed class CameraSensor : MonoBehaviour
    {
        [SerializeField, Tooltip("Looks when it is asked to; it is disabled")] private Camera source;
        [SerializeField, Min(1), Tooltip("In pixels")] private int width = 32;
        [SerializeField, Min(1), Tooltip("In pixels")] private int height = 24;
        [SerializeField, Tooltip("Where it goes")] private string locator = "";
        [SerializeField, Tooltip("[height, width] in place of [height, width, 3]")] private bool greyscale;

        private Source place;
        private CameraView view;

        /// <summary>All that are enabled now. For the main thread.</summary>
        public static List<Source> All { get; } = new List<Source>();

        /// <summary>The camera. Set it before the first answer.</summary>
        public Camera Camera { get => source; set => source = value; }

        // Not before all agents of the scene are there.
        private void Start()
        {
            try
            {
                place = Agent.Below(transform, $"CameraSensor on {name}", locator, "camera", Look);
                All.Add(place);
            }
            catch (ArgumentException e)
            {
                Debug.LogError($"gave up: {e.Message}");
                enabled = false;
            }
        }

        private void OnEnable()
        {
            if (place != null) All.Add(place);
        }

        private void OnDisable() => All.Remove(place);

        private void OnDestroy() => view?.Dispose();

        private object Look()
        {
            if (source == null) throw new MessageException("no-camera", $"CameraSensor on {name} has no camera");
            view ??= new CameraView(source, width, height, greyscale);
            return view.Look();
        }
    }
}
