// Lesson 11 in Unity, a ray sensor: which of some tags is where around the agents above it, as RayView.cs says.
//
// Use: put it on a game object somewhere below an agent's; SensorComponent.cs says under which key it comes. On the
// agent's own game object that is "rays". Its space in Python is Box(0, 1, (rays * (tags + 2),)). The fields have the
// names and meanings of ML-Agents' RayPerceptionSensorComponent3D.
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Some rays for each answer to Python.</summary>
    [AddComponentMenu("NetMQ Example/11 Ray Sensor")]
    public sealed class RaySensor : SensorComponent
    {
        [SerializeField, Tooltip("What is told apart")] private string[] detectableTags = { "Player" };
        [SerializeField, Range(0, 50), Tooltip("To each side of the one ahead")] private int raysPerDirection = 3;
        [SerializeField, Range(0, 180), Tooltip("From the one ahead to the last one")] private float maxRayDegrees = 70;
        [SerializeField, Range(0, 10), Tooltip("How thick they are, in metres")] private float sphereCastRadius = 0.5f;
        [SerializeField, Range(1, 1000), Tooltip("In metres")] private float rayLength = 20;
        // Physics.DefaultRaycastLayers: all but Ignore Raycast.
        [SerializeField, Tooltip("What they meet")] private LayerMask rayLayerMask = -5;

        private RayView view;

        /// <summary>The tags that it tells apart. Set them before the first answer.</summary>
        public string[] DetectableTags { get => detectableTags; set => detectableTags = value; }

        protected override string Key => "rays";

        public override object GetObservation() => (view ??= new RayView(transform, raysPerDirection, maxRayDegrees,
            rayLength, sphereCastRadius, rayLayerMask, detectableTags)).Observe();
    }
}
