// ML-Agents' shape, a segment: the actions of one kind, which are a part of an array.
//
//     var steer = actionsOut.ContinuousActions;
//     steer[0] = 1;                     writes into the array, of which a segment is no copy
using System;
using System.Collections;
using System.Collections.Generic;
using System.Linq;

namespace NetMQExample.MLAgents.Actuators
{
    /// <summary>A part of an array.</summary>
    /// <typeparam name="T">float for continuous actions, int for discrete ones.</typeparam>
    public readonly struct ActionSegment<T> : IEnumerable<T>, IEquatable<ActionSegment<T>>
        where T : struct
    {
        /// <summary>Where it begins in the array.</summary>
        public readonly int Offset;

        /// <summary>How many actions there are.</summary>
        public readonly int Length;

        /// <summary>One without actions.</summary>
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
        public T this[int index]
        {
            get => Array[Place(index)];
            set => Array[Place(index)] = value;
        }

        /// <summary>Makes all of them 0.</summary>
        public void Clear()
        {
            if (Length > 0) System.Array.Clear(Array, Offset, Length);
        }

        /// <summary>Whether its array is empty.</summary>
        public bool IsEmpty() => Array == null || Array.Length == 0;

        /// <inheritdoc/>
        public IEnumerator<T> GetEnumerator()
        {
            for (var i = 0; i < Length; i++) yield return Array[Offset + i];
        }

        IEnumerator IEnumerable.GetEnumerator() => GetEnumerator();

        /// <summary>Whether it is the same part of an equal array.</summary>
        public bool Equals(ActionSegment<T> other) =>
            Offset == other.Offset && Length == other.Length
            && (Array ?? Empty.Array).SequenceEqual(other.Array ?? Empty.Array);

        /// <inheritdoc/>
        public override bool Equals(object obj) => obj is ActionSegment<T> other && Equals(other);

        /// <inheritdoc/>
        public override int GetHashCode() => (Offset, Length).GetHashCode();

        private int Place(int index) => index >= 0 && index < Length ? Offset + index
            : throw new IndexOutOfRangeException($"action {index} of {Length}: does Behavior Parameters have as many?");
    }
}
