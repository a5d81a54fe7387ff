// ML-Agents' shape, a vector sensor: the numbers that CollectObservations adds.
using System.Collections.Generic;
using System.Collections.ObjectModel;
using UnityEngine;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>So many numbers. Too many are cut and too few are padded with zeros; both are said once.</summary>
    public class VectorSensor : ISensor
    {
        private readonly List<float> numbers;
        private readonly ReadOnlyCollection<float> seen;
        private readonly ObservationSpec spec;
        private readonly string name;
        private readonly int size;
        private int warned;

        /// <summary>With a size; without a name it is called by its size.</summary>
        public VectorSensor(
            int observationSize, string name = null, ObservationType observationType = ObservationType.Default)
        {
            var kind = observationType == ObservationType.Default ? "" : $"_{observationType}";
            this.name = string.IsNullOrEmpty(name) ? $"VectorSensor_size{observationSize}{kind}" : name;
            numbers = new List<float>(observationSize);
            seen = numbers.AsReadOnly();
            size = warned = observationSize;
            spec = ObservationSpec.Vector(observationSize, observationType);
        }

        /// <summary>Adds a number.</summary>
        /// <exception cref="UnityAgentsException">It is not finite; so with all that add.</exception>
        public void AddObservation(float observation) =>
            numbers.Add(UnityAgentsException.Finite(observation, nameof(AddObservation)));

        /// <summary>Adds a number.</summary>
        public void AddObservation(int observation) => AddObservation((float)observation);

        /// <summary>Adds x, y and z.</summary>
        public void AddObservation(Vector3 observation)
        {
            AddObservation(observation.x);
            AddObservation(observation.y);
            AddObservation(observation.z);
        }

        /// <summary>Adds x and y.</summary>
        public void AddObservation(Vector2 observation)
        {
            AddObservation(observation.x);
            AddObservation(observation.y);
        }

        /// <summary>Adds numbers, in their order.</summary>
        public void AddObservation(IList<float> observation)
        {
            for (var i = 0; i < observation.Count; i++) AddObservation(observation[i]);
        }

        /// <summary>Adds x, y, z and w.</summary>
        public void AddObservation(Quaternion observation)
        {
            AddObservation(observation.x);
            AddObservation(observation.y);
            AddObservation(observation.z);
            AddObservation(observation.w);
        }

        /// <summary>Adds 1 for true, 0 for false.</summary>
        public void AddObservation(bool observation) => AddObservation(observation ? 1f : 0f);

        /// <summary>Adds so many zeros, with a 1 at the place of a choice.</summary>
        public void AddOneHotObservation(int observation, int range)
        {
            for (var i = 0; i < range; i++) AddObservation(i == observation);
        }

        /// <inheritdoc/>
        public int Write(ObservationWriter writer)
        {
            var count = numbers.Count;
            if (count != size && count != warned)
            {
                warned = count;
                Debug.LogWarning($"{name} was given {count} numbers: "
                    + (count > size ? $"the last {count - size} are cut" : $"{size - count} zeros are padded")
                    + $". Set its size (Behavior Parameters, Vector Observation Size) to {count}");
            }
            if (count > size) numbers.RemoveRange(size, count - size);
            while (numbers.Count < size) numbers.Add(0);
            writer.AddList(numbers);
            return size;
        }

        /// <inheritdoc/>
        public void Update() => numbers.Clear();

        /// <inheritdoc/>
        public void Reset() => numbers.Clear();

        /// <inheritdoc/>
        public ObservationSpec GetObservationSpec() => spec;

        /// <inheritdoc/>
        public string GetName() => name;

        /// <inheritdoc/>
        public virtual byte[] GetCompressedObservation() => null;

        /// <inheritdoc/>
        public CompressionSpec GetCompressionSpec() => CompressionSpec.Default();

        // What was added since the last decision.
        internal ReadOnlyCollection<float> GetObservations() => seen;
    }
}
