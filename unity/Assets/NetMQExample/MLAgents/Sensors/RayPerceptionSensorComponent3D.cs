// ML-Agents' shape, rays in 3D: in the plane of x and z, the one ahead along z.
using UnityEngine;
using UnityEngine.Serialization;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>Rays that meet colliders of 3D.</summary>
    [AddComponentMenu("NetMQ Example/ML-Agents/Ray Perception Sensor 3D")]
    public class RayPerceptionSensorComponent3D : RayPerceptionSensorComponentBase
    {
        [SerializeField, FormerlySerializedAs("startVerticalOffset"), Range(-10, 10), Tooltip("How high rays begin")]
        private float m_StartVerticalOffset;
        [SerializeField, FormerlySerializedAs("endVerticalOffset"), Range(-10, 10), Tooltip("How high rays end")]
        private float m_EndVerticalOffset;

        public float StartVerticalOffset { get => m_StartVerticalOffset; set => Set(ref m_StartVerticalOffset, value); }
        public float EndVerticalOffset { get => m_EndVerticalOffset; set => Set(ref m_EndVerticalOffset, value); }

        public override RayPerceptionCastType GetCastType() => RayPerceptionCastType.Cast3D;
        public override float GetStartVerticalOffset() => m_StartVerticalOffset;
        public override float GetEndVerticalOffset() => m_EndVerticalOffset;
    }
}
