// Lesson 12 in Unity: several views of a running game become films, on command. The command comes from Python.
//
// Use: add this component to any GameObject of any scene, drag the cameras that can be filmed into Cameras, or none for
// the main camera alone, press Play, and start python/12_video/server.py, or a script of your own with films.py. A view
// has the name of its camera.
using System;
using System.Collections.Generic;
using System.Threading;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Offers cameras to Python. While nobody films it costs nothing.</summary>
    [AddComponentMenu("NetMQ Example/12 View Recorder")]
    public sealed class ViewRecorder : NetworkBehaviour
    {
        [SerializeField, Tooltip("Where Python films")] private string endpoint = "tcp://127.0.0.1:5562";
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait for Python")] private float timeout = 3600;
        [SerializeField, Tooltip("Can be filmed; else the main one")] private List<Camera> cameras = new List<Camera>();
        [SerializeField, Min(1), Tooltip("The widest picture that Python may ask for")] private int width = 320;
        [SerializeField, Min(1), Tooltip("The highest picture that Python may ask for")] private int height = 240;

        private FilmedCamera[] filmed = Array.Empty<FilmedCamera>();
        private volatile ViewSender sender;

        public bool Connected => sender?.Connected == true;

        /// <summary>Whether a film is made of any of them, or has ended and that is not logged yet.</summary>
        public bool Filming => Array.Exists(filmed, one => one.View.Filming) || Waiting;

        /// <summary>Also once whatever else of its object talks to Python has ended, such as a GymManager.</summary>
        public override bool Done
        {
            get
            {
                var others = Array.FindAll(GetComponents<NetworkBehaviour>(), one => !(one is ViewRecorder));
                return base.Done || (others.Length > 0 && Array.TrueForAll(others, one => one.Done));
            }
        }

        /// <summary>The cameras to film. Change them before this component is enabled, or in Awake.</summary>
        public List<Camera> Cameras => cameras;

        protected override void Talk(CancellationToken stop)
        {
            Log($"asking {endpoint}");
            using var own = sender = new ViewSender(endpoint, Seconds(timeout), Log);
            var offered = FromUpdate(Offer);
            own.Run(Array.ConvertAll(offered, one => one.View), stop);
        }

        private FilmedCamera[] Offer()
        {
            // In Update, since another component's Awake may come after this one is enabled.
            if (cameras.Count == 0 && Camera.main != null) cameras.Add(Camera.main);
            if (cameras.Count == 0)
                throw new ArgumentException("no camera to film: drag some into Cameras, or tag one MainCamera");
            OnDestroy();
            return filmed = cameras.ConvertAll(one => new FilmedCamera(one, width, height)).ToArray();
        }

        private void LateUpdate()
        {
            foreach (var one in filmed) one.Poll();
        }

        private void OnDestroy()
        {
            foreach (var one in filmed) one.Dispose();
        }
    }
}
