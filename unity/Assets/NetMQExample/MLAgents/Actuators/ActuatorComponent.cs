// ML-Agents' shape, an actuator's component. Scripts with actuators of their own compile; an agent says that they do not
// act.
using UnityEngine;

namespace NetMQExample.MLAgents.Actuators
{
    /// <summary>Makes actuators, which are not called.</summary>
    public abstract class ActuatorComponent : MonoBehaviour
    {
        /// <summary>Their actions.</summary>
        public abstract ActionSpec ActionSpec { get; }

        /// <summary>Makes them.</summary>
        public abstract IActuator[] CreateActuators();
    }
}
