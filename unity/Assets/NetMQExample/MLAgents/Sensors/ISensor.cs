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
using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using UnityEngine;

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
        public int[] CompressedChannelMapping { get; }

        public static CompressionSpec Default() => new CompressionSpec(SensorCompressionType.None);
    }

    [Flags]
    public enum DimensionProperty
    {
        /// <summary>Nothing is known.</summary>
        Unspecified = 0,
        /// <summary>Nothing.</summary>
        None = 1,
        /// <summary>Neighbours belong together, as in a picture.</summary>
        TranslationalEquivariance = 2,
        /// <summary>It may be shorter: rows of zeros are padding.</summary>
        VariableSize = 4,
    }

    public enum ObservationType
    {
        Default = 0,
        /// <summary>It is the agent's task.</summary>
        GoalSignal = 1,
    }

    /// <summary>The array of a sensor.</summary>
    public readonly struct ObservationSpec
    {
        /// <summary>Of any shape.</summary>
        /// <exception cref="UnityAgentsException">There are not as many properties as dimensions.</exception>
        public ObservationSpec(int[] shape, DimensionProperty[] dimensionProperties,
            ObservationType observationType = ObservationType.Default)
        {
            if (Require.Given("shape", shape).Length
                != Require.Given("dimensionProperties", dimensionProperties).Length)
                throw new UnityAgentsException($"an ObservationSpec has {shape.Length} dimensions and "
                    + $"{dimensionProperties.Length} properties: give each dimension one");
            Shape = shape;
            DimensionProperties = dimensionProperties;
            ObservationType = observationType;
        }

        public int[] Shape { get; }
        public DimensionProperty[] DimensionProperties { get; }
        public ObservationType ObservationType { get; }
        public int Rank => Shape.Length;

        public static ObservationSpec Vector(int length, ObservationType obsType = ObservationType.Default) =>
            new ObservationSpec(new[] { length }, new[] { DimensionProperty.None }, obsType);

        /// <summary>Some rows of the same size, of which the last ones may be missing.</summary>
        public static ObservationSpec VariableLength(int obsSize, int maxNumObs) => new ObservationSpec(
            new[] { obsSize, maxNumObs }, new[] { DimensionProperty.VariableSize, DimensionProperty.None });

        public static ObservationSpec Visual(
            int channels, int height, int width, ObservationType obsType = ObservationType.Default)
        {
            const DimensionProperty Place = DimensionProperty.TranslationalEquivariance;
            return new ObservationSpec(
                new[] { channels, height, width }, new[] { DimensionProperty.None, Place, Place }, obsType);
        }
    }

    /// <summary>The array of one sensor. Numbers that are not written are 0.</summary>
    public class ObservationWriter
    {
        private float[] numbers = new float[0];
        private int size, height, width;

        public float this[int index] { set => numbers[Within(index, size)] = value; }
        public float this[int ch, int w] { set => this[(ch * width) + Within(w, width)] = value; }

        /// <summary>A number of a picture, from 0 to 1; the highest row is 0.</summary>
        public float this[int ch, int h, int w] { set => this[(ch * height) + Within(h, height), w] = value; }

        public void AddList(IList<float> data, int writeOffset = 0)
        {
            for (var i = 0; i < data.Count; i++) this[writeOffset + i] = data[i];
        }

        public void Add(Vector3 vec, int writeOffset = 0) => AddList(new[] { vec.x, vec.y, vec.z }, writeOffset);
        public void Add(Vector4 vec, int writeOffset = 0) => AddList(new[] { vec.x, vec.y, vec.z, vec.w }, writeOffset);

        public void Add(Quaternion quat, int writeOffset = 0) =>
            Add(new Vector4(quat.x, quat.y, quat.z, quat.w), writeOffset);

        /// <summary>Writes the pixels of a texture, in colour or as the mean of red, green and blue.</summary>
        /// <returns>How many numbers these are.</returns>
        public int WriteTexture(Texture2D texture, bool grayScale)
        {
            var pixels = texture.GetPixels32();
            for (var i = 0; i < pixels.Length; i++)
            {
                var pixel = pixels[i];
                // Unity's lowest row is the first one.
                int h = texture.height - 1 - (i / texture.width), w = i % texture.width;
                this[0, h, w] = grayScale ? (pixel.r + pixel.g + pixel.b) / 3f / 255f : pixel.r / 255f;
                if (grayScale) continue;
                this[1, h, w] = pixel.g / 255f;
                this[2, h, w] = pixel.b / 255f;
            }
            return pixels.Length * (grayScale ? 1 : 3);
        }

        // Its numbers are good until the next sensor writes.
        internal ReadOnlySpan<byte> BytesOf(ISensor sensor)
        {
            var shape = sensor.GetObservationSpec().Shape;
            size = sensor.ObservationSize();
            width = shape[shape.Length - 1];
            height = shape.Length > 1 ? shape[shape.Length - 2] : 1;
            if (numbers.Length < size) numbers = new float[size];
            Array.Clear(numbers, 0, size);
            sensor.Write(this);
            return MemoryMarshal.AsBytes(numbers.AsSpan(0, size));
        }

        private static int Within(int place, int end) => place >= 0 && place < end ? place : throw Outside(place, end);

        private static UnityAgentsException Outside(int place, int end) => new UnityAgentsException(
            $"a sensor writes to place {place} of {end}: compare its Write with its GetObservationSpec");
    }
}
