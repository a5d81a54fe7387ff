// ML-Agents' shape, a stack: what a sensor has seen now and at earlier decisions, the oldest first; zeros before the
// first one of an episode.
using System;
using System.Collections.Generic;
using System.Collections.ObjectModel;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>So many observations of one sensor, as one. Pictures have so many times more channels.</summary>
    public class StackingSensor : BuiltInSensor, IPicture, IDisposable
    {
        private readonly ISensor wrapped;
        private readonly ObservationWriter local = new ObservationWriter();
        private readonly float[][] numbers;
        private readonly byte[][] pictures;
        private readonly int count, size;
        private int now;

        /// <summary>Around a sensor.</summary>
        /// <exception cref="UnityAgentsException">It is no vector and no picture.</exception>
        public StackingSensor(ISensor wrapped, int numStackedObservations)
            : base($"StackingSensor_size{numStackedObservations}_{Require.Given("wrapped", wrapped).GetName()}",
                Stacked(wrapped, numStackedObservations))
        {
            this.wrapped = wrapped;
            count = numStackedObservations;
            size = wrapped.ObservationSize();
            numbers = new float[count][];
            pictures = new byte[count][];
            for (var i = 0; i < count; i++)
            {
                numbers[i] = new float[size];
                pictures[i] = new byte[size];
            }
        }

        bool IPicture.IsPicture => SensorRows.IsPicture(wrapped);

        /// <inheritdoc/>
        public override int Write(ObservationWriter writer)
        {
            local.SetTarget(numbers[now], wrapped);
            wrapped.Write(local);
            for (var i = 0; i < count; i++) writer.AddList(numbers[(now + 1 + i) % count], i * size);
            return count * size;
        }

        void IPicture.Write(Span<byte> to)
        {
            ((IPicture)wrapped).Write(pictures[now]);
            for (var i = 0; i < count; i++) pictures[(now + 1 + i) % count].AsSpan().CopyTo(to.Slice(i * size));
        }

        /// <inheritdoc/>
        public override void Update()
        {
            wrapped.Update();
            now = (now + 1) % count;
        }

        /// <inheritdoc/>
        public override void Reset()
        {
            wrapped.Reset();
            for (var i = 0; i < count; i++)
            {
                Array.Clear(numbers[i], 0, size);
                Array.Clear(pictures[i], 0, size);
            }
        }

        /// <summary>Destroys the textures of its sensor.</summary>
        public void Dispose() => (wrapped as IDisposable)?.Dispose();

        // A sensor alone, or in a stack.
        internal static ISensor Of(ISensor sensor, int stacks) =>
            stacks > 1 ? new StackingSensor(sensor, stacks) : sensor;

        // As they were sent last.
        internal ReadOnlyCollection<float> GetStackedObservations()
        {
            var all = new List<float>(count * size);
            for (var i = 0; i < count; i++) all.AddRange(numbers[(now + 1 + i) % count]);
            return all.AsReadOnly();
        }

        private static ObservationSpec Stacked(ISensor one, int count)
        {
            var spec = one.GetObservationSpec();
            var shape = (int[])spec.Shape.Clone();
            shape[0] *= count;
            return shape.Length == 1 || shape.Length == 3
                ? new ObservationSpec(shape, spec.DimensionProperties, spec.ObservationType)
                : throw new UnityAgentsException($"{one.GetName()} cannot be stacked: only vectors and pictures can");
        }
    }
}
