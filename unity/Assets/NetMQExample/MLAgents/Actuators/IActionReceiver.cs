// ML-Agents' shape, parts of an agent: it gets actions, forbids choices and has a heuristic. Scripts with actuators of
// their own compile; an agent says that they do not act.
using UnityEngine;

namespace NetMQExample.MLAgents.Actuators
{
    /// <summary>A thing that acts.</summary>
    public interface IActionReceiver
    {
        /// <summary>Acts.</summary>
        void OnActionReceived(ActionBuffers actionBuffers);

        /// <summary>Forbids choices for the next decision.</summary>
        void WriteDiscreteActionMask(IDiscreteActionMask actionMask);
    }

    /// <summary>A thing that decides by itself where Python does not.</summary>
    public interface IHeuristicProvider
    {
        /// <summary>Writes its decision into the buffers.</summary>
        void Heuristic(in ActionBuffers actionBuffersOut);
    }

    /// <summary>A part of an agent that acts for itself. It compiles, and is not called.</summary>
    public interface IActuator : IActionReceiver, IHeuristicProvider
    {
        /// <summary>Its actions.</summary>
        ActionSpec ActionSpec { get; }

        /// <summary>Its name.</summary>
        string Name { get; }

        /// <summary>An episode is over.</summary>
        void ResetData();
    }

    /// <summary>Makes actuators, which are not called.</summary>
    public abstract class ActuatorComponent : MonoBehaviour
    {
        /// <summary>Their actions.</summary>
        public abstract ActionSpec ActionSpec { get; }

        /// <summary>Makes them.</summary>
        public abstract IActuator[] CreateActuators();
    }
}
