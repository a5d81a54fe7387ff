// ML-Agents' shape, a stack: what a sensor has seen now and at earlier decisions, the oldest first; zeros before the
// first one of an episode.
using System;
using System.Collections.Generic;
using System.Collections.ObjectModel;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>So many observations of one sensor, as one. Pictures have so many times more channels.</summary>
    public class StackingSensor : ISensor, IPicture
    {
        private readonly ISensor wrapped;
        private readonly ObservationSpec spec;
        private readonly ObservationWriter writer = new ObservationWriter();
        private readonly float[][] numbers;
        private readonly byte[][] pictures;
        private readonly int count, size;
        private int now;

        /// <summary>Around a sensor.</summary>
        /// <exception cref="UnityAgentsException">It is no vector and no picture.</exception>
        public StackingSensor(ISensor wrapped, int numStackedObservations)
        {
            this.wrapped = wrapped;
            count = numStackedObservations;
            var one = wrapped.GetObservationSpec();
            var shape = one.Shape;
            if (shape.Length != 1 && shape.Length != 3)
                throw new UnityAgentsException($"{wrapped.GetName()} cannot be stacked: only vectors and pictures can be");
            spec = new ObservationSpec(
                shape.Length == 1
                    ? new InplaceArray<int>(shape[0] * count)
                    : new InplaceArray<int>(shape[0] * count, shape[1], shape[2]),
                one.DimensionProperties, one.ObservationType);
            size = wrapped.ObservationSize();
            numbers = new float[count][];
            pictures = new byte[count][];
            for (var i = 0; i < count; i++)
            {
                if (IsPicture) pictures[i] = new byte[size];
                else numbers[i] = new float[size];
            }
        }

        bool IPicture.IsPicture => IsPicture;

        private bool IsPicture => SensorRows.IsPicture(wrapped);

        /// <inheritdoc/>
        public int Write(ObservationWriter writer)
        {
            if (IsPicture)
            {
                ((IPicture)wrapped).Write(pictures[now]);
                for (var i = 0; i < count * size; i++) writer[i] = pictures[(now + 1 + (i / size)) % count][i % size] / 255f;
                return count * size;
            }
            this.writer.SetTarget(numbers[now], wrapped);
            wrapped.Write(this.writer);
            for (var i = 0; i < count; i++) writer.AddList(numbers[(now + 1 + i) % count], i * size);
            return count * size;
        }

        void IPicture.Write(Span<byte> to)
        {
            ((IPicture)wrapped).Write(pictures[now]);
            for (var i = 0; i < count; i++) pictures[(now + 1 + i) % count].AsSpan().CopyTo(to.Slice(i * size));
        }

        /// <inheritdoc/>
        public void Update()
        {
            wrapped.Update();
            now = (now + 1) % count;
        }

        /// <inheritdoc/>
        public void Reset()
        {
            wrapped.Reset();
            for (var i = 0; i < count; i++)
            {
                if (IsPicture) Array.Clear(pictures[i], 0, size);
                else Array.Clear(numbers[i], 0, size);
            }
        }

        /// <inheritdoc/>
        public ObservationSpec GetObservationSpec() => spec;

        /// <inheritdoc/>
        public string GetName() => $"StackingSensor_size{count}_{wrapped.GetName()}";

        /// <inheritdoc/>
        public byte[] GetCompressedObservation() => null;

        /// <inheritdoc/>
        public CompressionSpec GetCompressionSpec() => wrapped.GetCompressionSpec();

        // A sensor alone, or in a stack.
        internal static ISensor Of(ISensor sensor, int stacks) => stacks > 1 ? new StackingSensor(sensor, stacks) : sensor;

        // As they were sent last.
        internal ReadOnlyCollection<float> GetStackedObservations()
        {
            var all = new List<float>(count * size);
            for (var i = 0; i < count; i++) all.AddRange(numbers[(now + 1 + i) % count]);
            return all.AsReadOnly();
        }
    }
}
