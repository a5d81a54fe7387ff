// ML-Agents' shape, a buffer sensor: things of which there are sometimes more and sometimes fewer.
using System;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>So many rows at the most; those that are missing are zeros.</summary>
    public class BufferSensor : ISensor
    {
        private readonly string name;
        private readonly int most, size;
        private readonly float[] rows;
        private readonly ObservationSpec spec;
        private int count;

        /// <summary>With its sizes.</summary>
        public BufferSensor(int maxNumberObs, int obsSize, string name)
        {
            this.name = name;
            most = maxNumberObs;
            size = obsSize;
            rows = new float[most * size];
            spec = ObservationSpec.VariableLength(most, size);
        }

        /// <summary>Adds a row; one more than there is room for is passed over.</summary>
        /// <exception cref="UnityAgentsException">It has another size, or is not finite.</exception>
        public void AppendObservation(float[] obs)
        {
            if (obs.Length != size)
                throw new UnityAgentsException(
                    $"{name} was given a row of {obs.Length} numbers: its Observable Size is {size}");
            foreach (var number in obs) UnityAgentsException.Finite(number, nameof(AppendObservation));
            if (count >= most) return;
            Array.Copy(obs, 0, rows, count * size, size);
            count++;
        }

        /// <inheritdoc/>
        public int Write(ObservationWriter writer)
        {
            writer.AddList(rows);
            return rows.Length;
        }

        /// <inheritdoc/>
        public void Update() => Reset();

        /// <inheritdoc/>
        public void Reset()
        {
            count = 0;
            Array.Clear(rows, 0, rows.Length);
        }

        /// <inheritdoc/>
        public ObservationSpec GetObservationSpec() => spec;

        /// <inheritdoc/>
        public string GetName() => name;

        /// <inheritdoc/>
        public virtual byte[] GetCompressedObservation() => null;

        /// <inheritdoc/>
        public CompressionSpec GetCompressionSpec() => CompressionSpec.Default();
    }
}
