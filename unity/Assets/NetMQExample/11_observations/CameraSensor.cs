// Lesson 11 in Unity, a camera as a sensor: what it sees goes with the observation of the agents above it.
//
// Use: put it on a game object somewhere below an agent's, with the camera; SensorComponent.cs says under which key it
// comes. On the agent's own game object that is "camera".
// From a script: sensor.Camera = camera;, with Width, Height and Greyscale, before the first answer.
// The picture is uint8 [height, width, 3], or [height, width] in grey, the highest row first.
// Trouble: each answer waits for its pictures, and the main thread with it. That is what lock-step means.
using UnityEngine;

namespace NetMQExample
{
    /// <summary>A picture for each answer to Python.</summary>
    [AddComponentMenu("NetMQ Example/11 Camera Sensor")]
    public sealed class CameraSensor : SensorComponent
    {
        [SerializeField, Tooltip("Looks when it is asked to; it is disabled")] private Camera source;
        [SerializeField, Min(1), Tooltip("In pixels")] private int width = 32;
        [SerializeField, Min(1), Tooltip("In pixels")] private int height = 24;
        [SerializeField, Tooltip("[height, width] in place of [height, width, 3]")] private bool greyscale;

        private CameraView view;
        private byte[] picture;

        /// <summary>The camera. Set it, and what follows, before the first answer.</summary>
        public Camera Camera { get => source; set => source = value; }

        public int Width { get => width; set => width = value; }
        public int Height { get => height; set => height = value; }

        /// <summary>Whether the picture is [height, width] in place of [height, width, 3].</summary>
        public bool Greyscale { get => greyscale; set => greyscale = value; }

        protected override string Key => "camera";

        public override object GetObservation()
        {
            if (source == null) throw new MessageException("no-camera", "it has no camera");
            view ??= new CameraView(source, width, height, greyscale);
            // One for ever: an answer is sent before Python asks again.
            return view.Observe(picture ??= new byte[view.Size]);
        }

        protected override void Start()
        {
            base.Start();
            // Until Python's first question it would draw over the game's own.
            if (source != null) source.enabled = false;
        }

        private void OnDestroy() => view?.Dispose();
    }
}
