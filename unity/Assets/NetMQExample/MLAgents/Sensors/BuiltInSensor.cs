// ML-Agents' shape, a sensor of the kit's: a name and a shape, and nothing that is compressed.
namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>The base of the kit's sensors.</summary>
    public abstract class BuiltInSensor : ISensor
    {
        private readonly string name;
        private readonly ObservationSpec spec;

        internal BuiltInSensor(string name, ObservationSpec spec)
        {
            this.name = Require.Given("name", name);
            this.spec = spec;
        }

        /// <inheritdoc/>
        public abstract int Write(ObservationWriter writer);

        /// <inheritdoc/>
        public virtual void Update() { }

        /// <inheritdoc/>
        public virtual void Reset() { }

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
