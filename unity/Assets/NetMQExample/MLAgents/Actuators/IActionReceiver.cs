// ML-Agents' shape, parts of an agent: it gets actions, forbids choices and has a heuristic. Scripts with actuators of
// their own compile; an agent says that they do not act.
using UnityEngine;

namespace NetMQExample.MLAgents.Actuators
{
    /// <summary>A thing that acts.</summary>
    public interface IActionReceiver
    {
        void OnActionReceived(ActionBuffers actionBuffers);

        void WriteDiscreteActionMask(IDiscreteActionMask actionMask);
    }

    /// <summary>A thing that decides by itself where Python does not.</summary>
    public interface IHeuristicProvider
    {
        void Heuristic(in ActionBuffers actionBuffersOut);
    }

    /// <summary>A part of an agent that acts for itself. It compiles, and is not called.</summary>
    public interface IActuator : IActionReceiver, IHeuristicProvider
    {
        ActionSpec ActionSpec { get; }

        string Name { get; }

        void ResetData();
    }

    /// <summary>Makes actuators, which are not called.</summary>
    public abstract class ActuatorComponent : MonoBehaviour
    {
        public abstract ActionSpec ActionSpec { get; }

        public abstract IActuator[] CreateActuators();
    }
}
