// ML-Agents' shape, a buffer sensor as a component. CollectObservations calls AppendObservation for each thing.
using UnityEngine;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>Rows for the agent above it. Its fields have ML-Agents' names.</summary>
    [AddComponentMenu("NetMQ Example/ML-Agents/Buffer Sensor")]
    public class BufferSensorComponent : SensorComponent
    {
        [SerializeField, Tooltip("Sensors are sorted by it")] private string m_SensorName = "BufferSensor";
        [SerializeField, Min(0), Tooltip("How many numbers a row has")] private int m_ObservableSize;
        [SerializeField, Min(0), Tooltip("How many rows")] private int m_MaxNumObservables;

        private BufferSensor sensor;

        public string SensorName { get => m_SensorName; set => m_SensorName = value; }
        public int ObservableSize { get => m_ObservableSize; set => m_ObservableSize = value; }
        public int MaxNumObservables { get => m_MaxNumObservables; set => m_MaxNumObservables = value; }

        public override ISensor[] CreateSensors()
        {
            sensor = new BufferSensor(m_MaxNumObservables, m_ObservableSize, m_SensorName);
            return new ISensor[] { sensor };
        }

        public void AppendObservation(float[] obs) => sensor.AppendObservation(obs);
    }
}
