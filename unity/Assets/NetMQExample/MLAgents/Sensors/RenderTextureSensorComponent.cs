// ML-Agents' shape, a render texture's sensor as a component.
using UnityEngine;
using UnityEngine.Serialization;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>Pictures for the agent above it. Its fields have ML-Agents' names.</summary>
    [AddComponentMenu("NetMQ Example/ML-Agents/Render Texture Sensor")]
    public class RenderTextureSensorComponent : SensorComponent
    {
        [SerializeField, FormerlySerializedAs("renderTexture")] private RenderTexture m_RenderTexture;
        [SerializeField, FormerlySerializedAs("sensorName"), Tooltip("Sensors are sorted by it")]
        private string m_SensorName = "RenderTextureSensor";
        [SerializeField, FormerlySerializedAs("grayscale"), Tooltip("One channel in place of three")]
        private bool m_Grayscale;
        [SerializeField, Range(1, 50), Tooltip("How many go together")] private int m_ObservationStacks = 1;
        [SerializeField, FormerlySerializedAs("compression"), Tooltip("Is kept and not used")]
        private SensorCompressionType m_Compression = SensorCompressionType.PNG;

        public RenderTexture RenderTexture { get => m_RenderTexture; set => m_RenderTexture = value; }
        public string SensorName { get => m_SensorName; set => m_SensorName = value; }
        public bool Grayscale { get => m_Grayscale; set => m_Grayscale = value; }
        public int ObservationStacks { get => m_ObservationStacks; set => m_ObservationStacks = value; }
        public SensorCompressionType CompressionType { get => m_Compression; set => m_Compression = value; }

        public override ISensor[] CreateSensors()
        {
            if (m_RenderTexture == null)
                throw new UnityAgentsException($"{name}: its Render Texture Sensor has no Render Texture: give it one");
            var sensor = new RenderTextureSensor(m_RenderTexture, m_Grayscale, m_SensorName, m_Compression);
            return new[] { StackingSensor.Of(sensor, m_ObservationStacks) };
        }
    }
}
