// ML-Agents' shape, the sensors of an agent, in the order that Python has them: by their names.
using System;
using System.Collections.Generic;
using NetMQExample.MLAgents.Actuators;
using NetMQExample.MLAgents.Policies;
using NetMQExample.MLAgents.Sensors.Reflection;
using UnityEngine;

namespace NetMQExample.MLAgents.Sensors
{
    internal static class SensorList
    {
        /// <summary>Makes those of its components, of its children's and of its members with [Observable], and the one
        /// for CollectObservations.</summary>
        /// <param name="vector">The one for CollectObservations, or null.</param>
        /// <param name="stacked">The stack of it, or null.</param>
        public static List<ISensor> Of(
            MonoBehaviour agent, BehaviorParameters parameters, out VectorSensor vector, out StackingSensor stacked)
        {
            var all = new List<ISensor>();
            var observable = parameters.ObservableAttributeHandling;
            if (observable != ObservableAttributeOptions.Ignore)
                all.AddRange(ObservableSensor.Of(agent, observable == ObservableAttributeOptions.ExcludeInherited));
            var components = parameters.UseChildSensors
                ? agent.GetComponentsInChildren<SensorComponent>()
                : agent.GetComponents<SensorComponent>();
            foreach (var component in components) all.AddRange(Made(component, agent));
            var sizes = parameters.BrainParameters;
            vector = sizes.VectorObservationSize > 0 ? new VectorSensor(sizes.VectorObservationSize) : null;
            var last = vector == null ? null : StackingSensor.Of(vector, sizes.NumStackedVectorObservations);
            stacked = last as StackingSensor;
            if (last != null) all.Add(last);
            all.Sort((a, b) => string.Compare(a.GetName(), b.GetName(), StringComparison.InvariantCulture));
            for (var i = 1; i < all.Count; i++)
                if (all[i].GetName() == all[i - 1].GetName())
                    Debug.LogError($"{agent.name} has two sensors called {all[i].GetName()}, and their order may "
                        + "change: give each a Sensor Name of its own", agent);
            if (agent.GetComponentInChildren<ActuatorComponent>() != null)
                Debug.LogError($"{agent.name}: actuators of one's own do not act here: move what they do into "
                    + "OnActionReceived, and their actions into Behavior Parameters", agent);
            return all;
        }

        private static ISensor[] Made(SensorComponent component, MonoBehaviour agent)
        {
            try
            {
                var made = component.CreateSensors();
                return made != null && Array.IndexOf(made, null) < 0 ? made
                    : throw new UnityAgentsException("it has returned null: return an array of sensors");
            }
            catch (Exception e)
            {
                throw new UnityAgentsException($"{agent.name} stands still: CreateSensors of "
                    + $"{component.GetType().Name} on {component.name} has failed: {e.Message}", e);
            }
        }
    }
}
