// ML-Agents' shape, a ray sensor as a component, in 2D and in 3D. The editor draws its rays while it is selected.
using System.Collections.Generic;
using UnityEngine;
using UnityEngine.Serialization;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>Rays for the agent above it. Its fields have ML-Agents' names.</summary>
    public abstract class RayPerceptionSensorComponentBase : SensorComponent
    {
        [SerializeField, FormerlySerializedAs("sensorName"), Tooltip("Sensors are sorted by it")]
        private string m_SensorName = "RayPerceptionSensor";
        [SerializeField, FormerlySerializedAs("detectableTags"), Tooltip("The tags that rays tell apart")]
        private List<string> m_DetectableTags = new List<string>();
        [SerializeField, FormerlySerializedAs("raysPerDirection"), Range(0, 50), Tooltip("To each side of the first")]
        private int m_RaysPerDirection = 3;
        [SerializeField, FormerlySerializedAs("maxRayDegrees"), Range(0, 180), Tooltip("From the first to the last")]
        private float m_MaxRayDegrees = 70;
        [SerializeField, FormerlySerializedAs("sphereCastRadius"), Range(0, 10), Tooltip("How thick, in metres")]
        private float m_SphereCastRadius = 0.5f;
        [SerializeField, FormerlySerializedAs("rayLength"), Range(1, 1000), Tooltip("In metres")]
        private float m_RayLength = 20;
        // All but Ignore Raycast.
        [SerializeField, FormerlySerializedAs("rayLayerMask"), Tooltip("The layers that they meet")]
        private LayerMask m_RayLayerMask = -5;
        [SerializeField, FormerlySerializedAs("observationStacks"), Range(1, 50), Tooltip("How many go together")]
        private int m_ObservationStacks = 1;
        [SerializeField, Tooltip("Ahead, right, left, …; off: from the right to the left")]
        private bool m_AlternatingRayOrder = true;
        [SerializeField, Tooltip("Is kept and not used")] private bool m_UseBatchedRaycasts;
        [SerializeField, Tooltip("Of a ray that has met something near")] internal Color rayHitColor = Color.red;
        [SerializeField, Tooltip("Of a ray that has met nothing")] internal Color rayMissColor = Color.white;

        public string SensorName { get => m_SensorName; set => m_SensorName = value; }
        public List<string> DetectableTags { get => m_DetectableTags; set => m_DetectableTags = value; }
        public int RaysPerDirection { get => m_RaysPerDirection; set => m_RaysPerDirection = value; }
        public float MaxRayDegrees { get => m_MaxRayDegrees; set => Set(ref m_MaxRayDegrees, value); }
        public float SphereCastRadius { get => m_SphereCastRadius; set => Set(ref m_SphereCastRadius, value); }
        public float RayLength { get => m_RayLength; set => Set(ref m_RayLength, value); }
        public LayerMask RayLayerMask { get => m_RayLayerMask; set => Set(ref m_RayLayerMask, value); }
        public int ObservationStacks { get => m_ObservationStacks; set => m_ObservationStacks = value; }

        /// <summary>Whether the order is ahead, right, left, … rather than from the right to the left.</summary>
        public bool AlternatingRayOrder { get => m_AlternatingRayOrder; set => m_AlternatingRayOrder = value; }

        public bool UseBatchedRaycasts { get => m_UseBatchedRaycasts; set => m_UseBatchedRaycasts = value; }
        public RayPerceptionSensor RaySensor { get; private set; }

        public abstract RayPerceptionCastType GetCastType();

        public virtual float GetStartVerticalOffset() => 0;
        public virtual float GetEndVerticalOffset() => 0;

        public override ISensor[] CreateSensors()
        {
            RaySensor = new RayPerceptionSensor(m_SensorName, GetRayPerceptionInput());
            return new[] { StackingSensor.Of(RaySensor, m_ObservationStacks) };
        }

        public RayPerceptionInput GetRayPerceptionInput() => new RayPerceptionInput
        {
            RayLength = m_RayLength,
            DetectableTags = m_DetectableTags,
            Angles = RayPerceptionInput.AnglesOf(m_RaysPerDirection, m_MaxRayDegrees, m_AlternatingRayOrder),
            StartOffset = GetStartVerticalOffset(),
            EndOffset = GetEndVerticalOffset(),
            CastRadius = m_SphereCastRadius,
            Transform = transform,
            CastType = GetCastType(),
            LayerMask = m_RayLayerMask,
            UseBatchedRaycasts = m_UseBatchedRaycasts,
        };

        // For a setting that may change in Play.
        private protected void Set<T>(ref T setting, T value)
        {
            setting = value;
            RaySensor?.SetRayPerceptionInput(GetRayPerceptionInput());
        }

        private void OnDrawGizmosSelected()
        {
            var rays = RaySensor?.RayPerceptionOutput.RayOutputs
                ?? RayPerceptionSensor.Perceive(GetRayPerceptionInput()).RayOutputs;
            foreach (var ray in rays)
            {
                var way = (ray.EndPositionWorld - ray.StartPositionWorld) * ray.HitFraction;
                Gizmos.color = Color.Lerp(rayHitColor, rayMissColor, ray.HitFraction * ray.HitFraction);
                Gizmos.DrawRay(ray.StartPositionWorld, way);
                if (ray.HasHit)
                    Gizmos.DrawWireSphere(ray.StartPositionWorld + way, Mathf.Max(ray.ScaledCastRadius, 0.05f));
            }
        }
    }
}
