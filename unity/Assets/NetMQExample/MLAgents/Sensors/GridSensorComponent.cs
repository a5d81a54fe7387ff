// ML-Agents' shape, a grid sensor: in a scene it is no missing script, and says that it does not see.
using UnityEngine;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>It makes no sensor.</summary>
    [AddComponentMenu("")]
    public class GridSensorComponent : SensorComponent
    {
        public override ISensor[] CreateSensors()
        {
            Debug.LogError($"{name}: a Grid Sensor does not see here: use a Ray Perception Sensor, or write a "
                + "SensorComponent of your own", this);
            return new ISensor[0];
        }
    }
}
