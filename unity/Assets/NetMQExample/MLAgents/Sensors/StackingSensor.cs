// ML-Agents' shape, a stack: what a sensor has seen now and at earlier decisions, the oldest first; zeros before the
// first one of an episode.
using System;
using System.Collections.ObjectModel;
using System.Runtime.InteropServices;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>So many observations of one sensor, as one. Pictures have so many times more channels.</summary>
    public class StackingSensor : BuiltInSensor, IRow, IDisposable
    {
        private readonly ISensor wrapped;
        private readonly ObservationWriter writer = new ObservationWriter();
        private readonly byte[] rows;
        private readonly int size;

        /// <summary>Around a sensor.</summary>
        /// <exception cref="UnityAgentsException">It is no vector and no picture.</exception>
        public StackingSensor(ISensor wrapped, int numStackedObservations)
            : base($"StackingSensor_size{numStackedObservations}_{Require.Given("wrapped", wrapped).GetName()}",
                Stacked(wrapped, numStackedObservations))
        {
            this.wrapped = wrapped;
            size = SensorRows.Size(wrapped);
            rows = new byte[size * numStackedObservations];
        }

        bool IRow.IsPicture => SensorRows.IsPicture(wrapped);

        public override int Write(ObservationWriter writer)
        {
            Look();
            var seen = GetStackedObservations();
            writer.AddList(seen);
            return seen.Count;
        }

        void IRow.WriteRow(Span<byte> to)
        {
            Look();
            rows.CopyTo(to);
        }

        public override void Update()
        {
            wrapped.Update();
            Array.Copy(rows, size, rows, 0, rows.Length - size);
        }

        public override void Reset()
        {
            wrapped.Reset();
            Array.Clear(rows, 0, rows.Length);
        }

        public void Dispose() => (wrapped as IDisposable)?.Dispose();

        // A sensor alone, or in a stack.
        internal static ISensor Of(ISensor sensor, int stacks) =>
            stacks > 1 ? new StackingSensor(sensor, stacks) : sensor;

        // As they were sent last.
        internal ReadOnlyCollection<float> GetStackedObservations() => Array.AsReadOnly(SensorRows.IsPicture(wrapped)
            ? Array.ConvertAll(rows, one => one / 255f) : MemoryMarshal.Cast<byte, float>(rows).ToArray());

        private void Look()
        {
            var last = rows.AsSpan(rows.Length - size);
            if (wrapped is IRow row) row.WriteRow(last);
            else writer.BytesOf(wrapped).CopyTo(last);
        }

        private static ObservationSpec Stacked(ISensor one, int count)
        {
            var spec = one.GetObservationSpec();
            if (spec.Rank != 1 && spec.Rank != 3)
                throw new UnityAgentsException($"{one.GetName()} cannot be stacked: only vectors and pictures can");
            var shape = (int[])spec.Shape.Clone();
            shape[0] *= count;
            return new ObservationSpec(shape, spec.DimensionProperties, spec.ObservationType);
        }
    }
}
