// ML-Agents' shape, a vector sensor as a component: a script finds it and adds numbers to GetSensor().
using UnityEngine;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>One vector more for the agent above it. Its fields have ML-Agents' names.</summary>
    [AddComponentMenu("NetMQ Example/ML-Agents/Vector Sensor")]
    public class VectorSensorComponent : SensorComponent
    {
        [SerializeField, Tooltip("Sensors are sorted by it")] private string m_SensorName = "VectorSensor";
        [SerializeField, Min(0), Tooltip("How many numbers")] private int m_ObservationSize;
        [SerializeField, Tooltip("Whether it is the agent's task")] private ObservationType m_ObservationType;
        [SerializeField, Range(1, 50), Tooltip("How many of them go together")] private int m_ObservationStacks = 1;

        private VectorSensor sensor;

        public string SensorName { get => m_SensorName; set => m_SensorName = value; }
        public int ObservationSize { get => m_ObservationSize; set => m_ObservationSize = value; }
        public ObservationType ObservationType { get => m_ObservationType; set => m_ObservationType = value; }
        public int ObservationStacks { get => m_ObservationStacks; set => m_ObservationStacks = value; }

        public override ISensor[] CreateSensors()
        {
            sensor = new VectorSensor(m_ObservationSize, m_SensorName, m_ObservationType);
            return new[] { StackingSensor.Of(sensor, m_ObservationStacks) };
        }

        public VectorSensor GetSensor() => sensor;
    }
}
