// ML-Agents' shape, a sensor of the kit's, and the array of each sensor as it stands in a record. Pictures are uint8,
// 255 for 1.0; all others are float32.
using System;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>The base of the kit's sensors: a name and a shape, and nothing that is compressed.</summary>
    public abstract class BuiltInSensor : ISensor
    {
        private readonly string name;
        private readonly ObservationSpec spec;

        internal BuiltInSensor(string name, ObservationSpec spec)
        {
            this.name = Require.Given("name", name);
            this.spec = spec;
        }

        public abstract int Write(ObservationWriter writer);

        public virtual void Update() { }
        public virtual void Reset() { }
        public ObservationSpec GetObservationSpec() => spec;
        public string GetName() => name;
        public virtual byte[] GetCompressedObservation() => null;
        public CompressionSpec GetCompressionSpec() => CompressionSpec.Default();
    }

    /// <summary>A sensor that has its array as bytes.</summary>
    internal interface IRow
    {
        /// <summary>Whether each byte is a number, [channels, height, width].</summary>
        bool IsPicture { get; }

        void WriteRow(Span<byte> to);
    }

    /// <summary>For the main thread. It makes no garbage, unless a sensor does.</summary>
    internal static class SensorRows
    {
        private static readonly ObservationWriter Writer = new ObservationWriter();

        public static bool IsPicture(ISensor sensor) => sensor is IRow row && row.IsPicture;
        public static int Size(ISensor sensor) => sensor.ObservationSize() * (IsPicture(sensor) ? 1 : sizeof(float));

        public static void Write(ISensor sensor, FrameBuffer to)
        {
            if (sensor is IRow row)
            {
                var size = Size(sensor);
                row.WriteRow(to.GetSpan(size).Slice(0, size));
                to.Advance(size);
            }
            else to.Write(Writer.BytesOf(sensor));
        }
    }
}
