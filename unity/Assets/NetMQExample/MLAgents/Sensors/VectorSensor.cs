// ML-Agents' shape, a vector sensor: the numbers that CollectObservations adds.
using System;
using System.Collections.Generic;
using System.Collections.ObjectModel;
using UnityEngine;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>So many numbers. Too many are cut and too few are padded with zeros; both are said once.</summary>
    public class VectorSensor : BuiltInSensor
    {
        private readonly List<float> numbers;
        private readonly ReadOnlyCollection<float> seen;
        private readonly int size;
        private int warned;

        public VectorSensor(
            int observationSize, string name = null, ObservationType observationType = ObservationType.Default)
            : base(string.IsNullOrEmpty(name) ? NameOf(observationSize, observationType) : name,
                ObservationSpec.Vector(observationSize, observationType))
        {
            numbers = new List<float>(observationSize);
            seen = numbers.AsReadOnly();
            size = warned = observationSize;
        }

        /// <exception cref="UnityAgentsException">It is not finite; so with all that add.</exception>
        public void AddObservation(float observation) =>
            numbers.Add(UnityAgentsException.Finite(observation, nameof(AddObservation)));

        public void AddObservation(int observation) => AddObservation((float)observation);

        public void AddObservation(Vector3 observation)
        {
            AddObservation(observation.x);
            AddObservation(observation.y);
            AddObservation(observation.z);
        }

        public void AddObservation(Vector2 observation)
        {
            AddObservation(observation.x);
            AddObservation(observation.y);
        }

        public void AddObservation(IList<float> observation)
        {
            for (var i = 0; i < observation.Count; i++) AddObservation(observation[i]);
        }

        public void AddObservation(Quaternion observation)
        {
            AddObservation(new Vector3(observation.x, observation.y, observation.z));
            AddObservation(observation.w);
        }

        public void AddObservation(bool observation) => AddObservation(observation ? 1f : 0f);

        /// <summary>Adds so many zeros, with a 1 at the place of a choice.</summary>
        public void AddOneHotObservation(int observation, int range)
        {
            for (var i = 0; i < range; i++) AddObservation(i == observation);
        }

        public override int Write(ObservationWriter writer)
        {
            var count = numbers.Count;
            if (count != size && count != warned)
            {
                warned = count;
                Debug.LogWarning($"{GetName()} was given {count} numbers and has {size}: "
                    + (count > size ? "the rest is cut" : "zeros are padded")
                    + $". Set its size to {count}; that of CollectObservations is in Behavior Parameters");
            }
            if (count > size) numbers.RemoveRange(size, count - size);
            while (numbers.Count < size) numbers.Add(0);
            writer.AddList(numbers);
            return size;
        }

        public override void Update() => numbers.Clear();
        public override void Reset() => numbers.Clear();

        private static string NameOf(int size, ObservationType type) =>
            $"VectorSensor_size{size}{(type == ObservationType.Default ? "" : $"_{type}")}";

        // The numbers that were added since the last decision.
        internal ReadOnlyCollection<float> GetObservations() => seen;
    }

    /// <summary>So many rows at the most; those that are missing are zeros.</summary>
    public class BufferSensor : BuiltInSensor
    {
        private readonly int most, size;
        private readonly float[] rows;
        private int count;

        public BufferSensor(int maxNumberObs, int obsSize, string name)
            : base(name, ObservationSpec.VariableLength(maxNumberObs, obsSize))
        {
            most = maxNumberObs;
            size = obsSize;
            rows = new float[most * size];
        }

        /// <summary>Adds a row; one more than there is room for is passed over.</summary>
        /// <exception cref="UnityAgentsException">It has another size, or is not finite.</exception>
        public void AppendObservation(float[] obs)
        {
            if (obs.Length != size)
                throw new UnityAgentsException(
                    $"{GetName()} was given a row of {obs.Length} numbers: its Observable Size is {size}");
            foreach (var number in obs) UnityAgentsException.Finite(number, nameof(AppendObservation));
            if (count >= most) return;
            Array.Copy(obs, 0, rows, count * size, size);
            count++;
        }

        public override int Write(ObservationWriter writer)
        {
            writer.AddList(rows);
            return rows.Length;
        }

        public override void Update() => Reset();

        public override void Reset()
        {
            count = 0;
            Array.Clear(rows, 0, rows.Length);
        }
    }
}
