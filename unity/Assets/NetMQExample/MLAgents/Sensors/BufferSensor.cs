// ML-Agents' shape, a buffer sensor: things of which there are sometimes more and sometimes fewer.
using System;

namespace NetMQExample.MLAgents.Sensors
{
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
