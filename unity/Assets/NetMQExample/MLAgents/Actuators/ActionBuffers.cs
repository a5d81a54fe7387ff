// ML-Agents' shape, the actions of one step: continuous ones, discrete ones, or both; a segment has those of one kind.
//
//     var steer = actionsOut.ContinuousActions;
//     steer[0] = 1;                     writes into the array, of which a segment is no copy
using System;
using System.Collections;
using System.Collections.Generic;
using System.Linq;
using UnityEngine;

namespace NetMQExample.MLAgents.Actuators
{
    /// <summary>The actions that an agent gets, or that its Heuristic writes.</summary>
    public readonly struct ActionBuffers
    {
        public static ActionBuffers Empty = new ActionBuffers(ActionSegment<float>.Empty, ActionSegment<int>.Empty);

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

        public ActionSegment<float> ContinuousActions { get; }
        public ActionSegment<int> DiscreteActions { get; }

        /// <summary>Choices that are written as floats; null: none.</summary>
        public static ActionBuffers FromDiscreteActions(float[] discreteActions) =>
            new ActionBuffers(null, discreteActions?.Select(action => (int)action).ToArray());

        public void Clear()
        {
            ContinuousActions.Clear();
            DiscreteActions.Clear();
        }

        public bool IsEmpty() => ContinuousActions.IsEmpty() && DiscreteActions.IsEmpty();

        public override bool Equals(object obj) =>
            obj is ActionBuffers other && ContinuousActions.SequenceEqual(other.ContinuousActions)
            && DiscreteActions.SequenceEqual(other.DiscreteActions);

        public override int GetHashCode() => (ContinuousActions.Length, DiscreteActions.Length).GetHashCode();
    }

    /// <summary>A part of an array.</summary>
    /// <typeparam name="T">float for continuous actions, int for discrete ones.</typeparam>
    public readonly struct ActionSegment<T> : IEnumerable<T>, IEquatable<ActionSegment<T>>
        where T : struct
    {
        public readonly int Offset;
        public readonly int Length;
        public static ActionSegment<T> Empty = new ActionSegment<T>(null);

        /// <summary>All of an array; null: none.</summary>
        public ActionSegment(T[] actionArray) : this(actionArray, 0, actionArray?.Length ?? 0) { }

        /// <summary>A part of an array.</summary>
        /// <exception cref="ArgumentOutOfRangeException">The array ends before it.</exception>
        public ActionSegment(T[] actionArray, int offset, int length)
        {
            Array = actionArray ?? System.Array.Empty<T>();
            if (offset < 0 || length < 0 || offset + length > Array.Length)
                throw new ArgumentOutOfRangeException(nameof(offset),
                    $"{length} actions from {offset} on are more than the array's {Array.Length}");
            Offset = offset;
            Length = length;
        }

        /// <summary>The whole array, which others may share.</summary>
        public T[] Array { get; }

        /// <summary>One action; setting it writes into the array.</summary>
        /// <exception cref="IndexOutOfRangeException">There are fewer.</exception>
        public T this[int index] { get => Array[Place(index)]; set => Array[Place(index)] = value; }

        public void Clear() => Array.AsSpan(Offset, Length).Clear();
        public bool IsEmpty() => Array == null || Array.Length == 0;

        public IEnumerator<T> GetEnumerator()
        {
            for (var i = 0; i < Length; i++) yield return Array[Offset + i];
        }

        IEnumerator IEnumerable.GetEnumerator() => GetEnumerator();

        public bool Equals(ActionSegment<T> other) => Offset == other.Offset && Length == other.Length
            && (Array ?? Empty.Array).SequenceEqual(other.Array ?? Empty.Array);

        public override bool Equals(object obj) => obj is ActionSegment<T> other && Equals(other);
        public override int GetHashCode() => (Offset, Length).GetHashCode();

        private int Place(int index) => index >= 0 && index < Length ? Offset + index
            : throw new IndexOutOfRangeException($"action {index} of {Length}: does Behavior Parameters have as many?");
    }

    /// <summary>Which actions there are. Its fields have ML-Agents' names in scenes.</summary>
    [Serializable]
    public struct ActionSpec
    {
        [SerializeField, Tooltip("Numbers without limits"), Min(0)] private int m_NumContinuousActions;

        [Tooltip("The number of choices of each branch")] public int[] BranchSizes;

        public ActionSpec(int numContinuousActions = 0, int[] discreteBranchSizes = null)
        {
            m_NumContinuousActions = numContinuousActions;
            BranchSizes = discreteBranchSizes ?? Array.Empty<int>();
        }

        public int NumContinuousActions { get => m_NumContinuousActions; set => m_NumContinuousActions = value; }
        public int NumDiscreteActions => BranchSizes?.Length ?? 0;
        public int SumOfDiscreteBranchSizes => BranchSizes?.Sum() ?? 0;

        public static ActionSpec MakeContinuous(int numActions) => new ActionSpec(numActions, null);
        public static ActionSpec MakeDiscrete(params int[] branchSizes) => new ActionSpec(0, branchSizes);

        /// <exception cref="UnityAgentsException">An agent cannot act so.</exception>
        internal void Check(string agent)
        {
            var sizes = BranchSizes ?? Array.Empty<int>();
            var none = Array.FindIndex(sizes, size => size < 1);
            var wrong = NumContinuousActions < 0 ? $"Continuous Actions is {NumContinuousActions}: write 0 or more"
                : none >= 0 ? $"Branch Sizes has {sizes[none]} at branch {none}: give each branch a choice, or remove it"
                : null;
            if (wrong != null) throw new UnityAgentsException($"{agent} stands still: in its Behavior Parameters {wrong}");
        }

        public static ActionSpec Combine(params ActionSpec[] specs) => new ActionSpec(
            specs.Sum(spec => spec.NumContinuousActions),
            specs.SelectMany(spec => spec.BranchSizes ?? Array.Empty<int>()).ToArray());
    }
}
