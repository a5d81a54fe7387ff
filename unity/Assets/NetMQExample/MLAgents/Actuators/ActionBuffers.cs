// ML-Agents' shape, the actions of one step: continuous ones, discrete ones, or both.
using System;
using System.Linq;

namespace NetMQExample.MLAgents.Actuators
{
    /// <summary>The actions that an agent gets, or that its Heuristic writes.</summary>
    public readonly struct ActionBuffers
    {
        /// <summary>No actions.</summary>
        public static ActionBuffers Empty = new ActionBuffers(ActionSegment<float>.Empty, ActionSegment<int>.Empty);

        /// <summary>Of two segments.</summary>
        public ActionBuffers(ActionSegment<float> continuousActions, ActionSegment<int> discreteActions)
        {
            ContinuousActions = continuousActions;
            DiscreteActions = discreteActions;
        }

        /// <summary>Of two arrays, each of which may be null.</summary>
        public ActionBuffers(float[] continuousActions, int[] discreteActions)
            : this(new ActionSegment<float>(continuousActions), new ActionSegment<int>(discreteActions)) { }

        /// <summary>Zeros, as many as a specification says.</summary>
        public ActionBuffers(ActionSpec actionSpec)
            : this(new float[actionSpec.NumContinuousActions], new int[actionSpec.NumDiscreteActions]) { }

        /// <summary>Numbers without limits.</summary>
        public ActionSegment<float> ContinuousActions { get; }

        /// <summary>The choice of each branch.</summary>
        public ActionSegment<int> DiscreteActions { get; }

        /// <summary>Choices that are written as floats; null: none.</summary>
        public static ActionBuffers FromDiscreteActions(float[] discreteActions) =>
            new ActionBuffers(null,
                discreteActions == null ? null : Array.ConvertAll(discreteActions, action => (int)action));

        /// <summary>Makes all of them 0.</summary>
        public void Clear()
        {
            ContinuousActions.Clear();
            DiscreteActions.Clear();
        }

        /// <summary>Whether there are none.</summary>
        public bool IsEmpty() => ContinuousActions.IsEmpty() && DiscreteActions.IsEmpty();

        /// <inheritdoc/>
        public override bool Equals(object obj) =>
            obj is ActionBuffers other && ContinuousActions.SequenceEqual(other.ContinuousActions)
            && DiscreteActions.SequenceEqual(other.DiscreteActions);

        /// <inheritdoc/>
        public override int GetHashCode() => (ContinuousActions.Length, DiscreteActions.Length).GetHashCode();
    }
}
