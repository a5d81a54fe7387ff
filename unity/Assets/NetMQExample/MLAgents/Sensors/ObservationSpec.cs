// ML-Agents' shape, a specification: the shape of a sensor's array, and what trainers may make of each dimension.
using System;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>The nature of a dimension, for trainers.</summary>
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

    /// <summary>The purpose of an observation.</summary>
    public enum ObservationType
    {
        /// <summary>It is seen.</summary>
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

        /// <summary>The size of each dimension.</summary>
        public int[] Shape { get; }

        /// <summary>The property of each dimension.</summary>
        public DimensionProperty[] DimensionProperties { get; }

        /// <summary>Its purpose.</summary>
        public ObservationType ObservationType { get; }

        /// <summary>How many dimensions it has.</summary>
        public int Rank => Shape.Length;

        /// <summary>Numbers in a row.</summary>
        public static ObservationSpec Vector(int length, ObservationType obsType = ObservationType.Default) =>
            new ObservationSpec(new[] { length }, new[] { DimensionProperty.None }, obsType);

        /// <summary>Some rows of the same size, of which the last ones may be missing.</summary>
        public static ObservationSpec VariableLength(int obsSize, int maxNumObs) => new ObservationSpec(
            new[] { obsSize, maxNumObs }, new[] { DimensionProperty.VariableSize, DimensionProperty.None });

        /// <summary>A picture.</summary>
        public static ObservationSpec Visual(
            int channels, int height, int width, ObservationType obsType = ObservationType.Default)
        {
            const DimensionProperty Place = DimensionProperty.TranslationalEquivariance;
            return new ObservationSpec(
                new[] { channels, height, width }, new[] { DimensionProperty.None, Place, Place }, obsType);
        }
    }
}
