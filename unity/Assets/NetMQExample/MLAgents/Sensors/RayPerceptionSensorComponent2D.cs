// ML-Agents' shape, rays in 2D: in the plane of x and y, the one ahead along y.
using UnityEngine;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>Rays that meet colliders of 2D.</summary>
    [AddComponentMenu("NetMQ Example/ML-Agents/Ray Perception Sensor 2D")]
    public class RayPerceptionSensorComponent2D : RayPerceptionSensorComponentBase
    {
        public override RayPerceptionCastType GetCastType() => RayPerceptionCastType.Cast2D;
    }
}
