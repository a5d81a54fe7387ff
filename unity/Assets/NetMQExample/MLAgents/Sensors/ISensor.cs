// ML-Agents' shape, a sensor: it sees for an agent. One of your own is a class with these methods, and a
// SensorComponent that makes it:
//
//     public ObservationSpec GetObservationSpec() => ObservationSpec.Vector(2);
//     public int Write(ObservationWriter writer)
//     {
//         writer[0] = speed;
//         writer[1] = fuel;
//         return 2;
//     }
namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>One array in the observation of an agent.</summary>
    public interface ISensor
    {
        /// <summary>The shape and meaning of the array; they do not change.</summary>
        ObservationSpec GetObservationSpec();

        /// <summary>Writes the array.</summary>
        /// <returns>How many numbers it has.</returns>
        int Write(ObservationWriter writer);

        /// <summary>Nobody calls it: observations are sent as they are.</summary>
        byte[] GetCompressedObservation();

        /// <summary>A decision or the end of an episode is near: time to look.</summary>
        void Update();

        void Reset();

        /// <summary>Nobody calls it: observations are sent as they are.</summary>
        CompressionSpec GetCompressionSpec();

        /// <summary>Its name; sensors are sorted by it.</summary>
        string GetName();
    }

    /// <summary>The size, which follows from a sensor's methods.</summary>
    public static class SensorExtensions
    {
        public static int ObservationSize(this ISensor sensor)
        {
            var shape = sensor.GetObservationSpec().Shape;
            var size = 1;
            for (var i = 0; i < shape.Length; i++) size *= shape[i];
            return size;
        }
    }

    /// <summary>The ways to send a picture. All are sent as they are.</summary>
    public enum SensorCompressionType
    {
        None,
        PNG,
    }

    /// <summary>How a sensor of ML-Agents is compressed. Nothing here depends on it.</summary>
    public struct CompressionSpec
    {
        public CompressionSpec(SensorCompressionType sensorCompressionType, int[] compressedChannelMapping = null)
        {
            SensorCompressionType = sensorCompressionType;
            CompressedChannelMapping = compressedChannelMapping;
        }

        public SensorCompressionType SensorCompressionType { get; }

        /// <summary>The order of channels, or null.</summary>
        public int[] CompressedChannelMapping { get; }

        public static CompressionSpec Default() => new CompressionSpec(SensorCompressionType.None);
    }
}
