// ML-Agents' shape, a camera sensor as a component.
using UnityEngine;
using UnityEngine.Serialization;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>Pictures for the agent above it. Its fields have ML-Agents' names.</summary>
    [AddComponentMenu("NetMQ Example/ML-Agents/Camera Sensor")]
    public class CameraSensorComponent : SensorComponent
    {
        [SerializeField, FormerlySerializedAs("camera")] private Camera m_Camera;
        [SerializeField, FormerlySerializedAs("sensorName"), Tooltip("Sensors are sorted by it")]
        private string m_SensorName = "CameraSensor";
        [SerializeField, FormerlySerializedAs("width"), Min(1), Tooltip("In pixels")] private int m_Width = 84;
        [SerializeField, FormerlySerializedAs("height"), Min(1), Tooltip("In pixels")] private int m_Height = 84;
        [SerializeField, FormerlySerializedAs("grayscale"), Tooltip("One channel in place of three")]
        private bool m_Grayscale;
        [SerializeField, Tooltip("Whether it is the agent's task")] private ObservationType m_ObservationType;
        [SerializeField, Tooltip("Whether it draws on the screen as well")] private bool m_RuntimeCameraEnable;
        [SerializeField, Range(1, 50), Tooltip("How many go together")] private int m_ObservationStacks = 1;
        [SerializeField, FormerlySerializedAs("compression"), Tooltip("Is kept and not used")]
        private SensorCompressionType m_Compression = SensorCompressionType.PNG;

        private CameraSensor sensor;

        public Camera Camera { get => m_Camera; set => Set(ref m_Camera, value); }
        public string SensorName { get => m_SensorName; set => m_SensorName = value; }
        public int Width { get => m_Width; set => m_Width = value; }
        public int Height { get => m_Height; set => m_Height = value; }
        public bool Grayscale { get => m_Grayscale; set => m_Grayscale = value; }
        public ObservationType ObservationType { get => m_ObservationType; set => m_ObservationType = value; }
        public bool RuntimeCameraEnable { get => m_RuntimeCameraEnable; set => Set(ref m_RuntimeCameraEnable, value); }
        public int ObservationStacks { get => m_ObservationStacks; set => m_ObservationStacks = value; }
        public SensorCompressionType CompressionType { get => m_Compression; set => Set(ref m_Compression, value); }

        public override ISensor[] CreateSensors()
        {
            if (m_Camera == null)
                throw new UnityAgentsException($"{name}: its Camera Sensor has no Camera: give it one");
            sensor = new CameraSensor(
                m_Camera, m_Width, m_Height, m_Grayscale, m_SensorName, m_Compression, m_ObservationType);
            return new[] { StackingSensor.Of(sensor, m_ObservationStacks) };
        }

        private void Start() => Tell();

        private void Set<T>(ref T setting, T value)
        {
            setting = value;
            Tell();
        }

        private void Tell()
        {
            if (sensor == null || m_Camera == null) return;
            sensor.Camera = m_Camera;
            sensor.CompressionType = m_Compression;
            m_Camera.enabled = m_RuntimeCameraEnable;
        }
    }
}
