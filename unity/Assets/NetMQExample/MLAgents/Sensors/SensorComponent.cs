// ML-Agents' shape, a sensor's component: it makes the sensors of the agent above it.
using System;
using UnityEngine;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>Override CreateSensors. An agent calls it once, when it is enabled.</summary>
    public abstract class SensorComponent : MonoBehaviour
    {
        /// <exception cref="UnityAgentsException">The class overrides nothing.</exception>
        public virtual ISensor[] CreateSensors()
        {
#pragma warning disable CS0618
            var one = CreateSensor();
#pragma warning restore CS0618
            return one != null ? new[] { one }
                : throw new UnityAgentsException($"{GetType().Name} makes no sensor: override CreateSensors");
        }

        /// <summary>Makes one, as in ML-Agents 1.</summary>
        [Obsolete("Override CreateSensors.")]
        public virtual ISensor CreateSensor() => null;

        /// <summary>As in ML-Agents 1; nobody calls it.</summary>
        [Obsolete("A sensor's GetObservationSpec says it.")]
        public virtual int[] GetObservationShape() => null;
    }
}
