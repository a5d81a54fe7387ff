// ML-Agents' shape, a specification: the shape of a sensor's array, and what trainers may make of each dimension.
using System;

namespace NetMQExample.MLAgents
{
    /// <summary>One to four values.</summary>
    public readonly struct InplaceArray<T> where T : struct
    {
        private readonly T[] values;

        /// <summary>One.</summary>
        public InplaceArray(T elem0) => values = new[] { elem0 };

        /// <summary>Two.</summary>
        public InplaceArray(T elem0, T elem1) => values = new[] { elem0, elem1 };

        /// <summary>Three.</summary>
        public InplaceArray(T elem0, T elem1, T elem2) => values = new[] { elem0, elem1, elem2 };

        /// <summary>Four.</summary>
        public InplaceArray(T elem0, T elem1, T elem2, T elem3) => values = new[] { elem0, elem1, elem2, elem3 };

        /// <summary>How many there are.</summary>
        public int Length => values?.Length ?? 0;

        /// <summary>One of them.</summary>
        public T this[int index] => values[index];

        /// <inheritdoc/>
        public override string ToString() => $"[{string.Join(", ", values ?? Array.Empty<T>())}]";
    }
}

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>What a trainer may make of a dimension.</summary>
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

    /// <summary>What an observation is for.</summary>
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
        public ObservationSpec(InplaceArray<int> shape, InplaceArray<DimensionProperty> dimensionProperties,
            ObservationType observationType = ObservationType.Default)
        {
            if (shape.Length != dimensionProperties.Length)
                throw new UnityAgentsException($"an ObservationSpec has {shape.Length} dimensions and "
                    + $"{dimensionProperties.Length} properties: give each dimension one");
            Shape = shape;
            DimensionProperties = dimensionProperties;
            ObservationType = observationType;
        }

        /// <summary>The size of each dimension.</summary>
        public InplaceArray<int> Shape { get; }

        /// <summary>The property of each dimension.</summary>
        public InplaceArray<DimensionProperty> DimensionProperties { get; }

        /// <summary>What it is for.</summary>
        public ObservationType ObservationType { get; }

        /// <summary>How many dimensions it has.</summary>
        public int Rank => Shape.Length;

        /// <summary>Numbers in a row.</summary>
        public static ObservationSpec Vector(int length, ObservationType obsType = ObservationType.Default) =>
            new ObservationSpec(new InplaceArray<int>(length),
                new InplaceArray<DimensionProperty>(DimensionProperty.None), obsType);

        /// <summary>Some rows of the same size, of which the last ones may be missing.</summary>
        public static ObservationSpec VariableLength(int obsSize, int maxNumObs) =>
            new ObservationSpec(new InplaceArray<int>(obsSize, maxNumObs),
                new InplaceArray<DimensionProperty>(DimensionProperty.VariableSize, DimensionProperty.None));

        /// <summary>A picture.</summary>
        public static ObservationSpec Visual(
            int channels, int height, int width, ObservationType obsType = ObservationType.Default) =>
            new ObservationSpec(new InplaceArray<int>(channels, height, width),
                new InplaceArray<DimensionProperty>(DimensionProperty.None,
                    DimensionProperty.TranslationalEquivariance, DimensionProperty.TranslationalEquivariance), obsType);
    }
}
