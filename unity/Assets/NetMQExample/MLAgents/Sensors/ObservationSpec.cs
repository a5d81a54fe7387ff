// ML-Agents' shape, a specification: the shape of a sensor's array, and what trainers may make of each dimension.
using System;

namespace NetMQExample.MLAgents.Sensors
{
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
}
