// ML-Agents' shape, a sensor of the kit's, and the array of each sensor as it stands in a record. Pictures are uint8,
// 255 for 1.0; all others are float32.
using System;
using System.Collections.Generic;
using System.Collections.ObjectModel;
using System.Runtime.InteropServices;
using NetMQExample.MLAgents.Actuators;
using NetMQExample.MLAgents.Policies;
using NetMQExample.MLAgents.Sensors.Reflection;
using UnityEngine;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>The base of the kit's sensors: a name and a shape, and nothing that is compressed.</summary>
    public abstract class BuiltInSensor : ISensor
    {
        private readonly string name;
        private readonly ObservationSpec spec;

        internal BuiltInSensor(string name, ObservationSpec spec)
        {
            this.name = Require.Given("name", name);
            this.spec = spec;
        }

        public abstract int Write(ObservationWriter writer);

        public virtual void Update() { }
        public virtual void Reset() { }
        public ObservationSpec GetObservationSpec() => spec;
        public string GetName() => name;
        public virtual byte[] GetCompressedObservation() => null;
        public CompressionSpec GetCompressionSpec() => CompressionSpec.Default();
    }

    /// <summary>A sensor that has its array as bytes.</summary>
    internal interface IRow
    {
        /// <summary>Whether each byte is a number, [channels, height, width].</summary>
        bool IsPicture { get; }

        void WriteRow(Span<byte> to);
    }

    /// <summary>For the main thread. It makes no garbage, unless a sensor does.</summary>
    internal static class SensorRows
    {
        private static readonly ObservationWriter Writer = new ObservationWriter();

        public static bool IsPicture(ISensor sensor) => sensor is IRow row && row.IsPicture;
        public static int Size(ISensor sensor) => sensor.ObservationSize() * (IsPicture(sensor) ? 1 : sizeof(float));

        public static void Write(ISensor sensor, FrameBuffer to)
        {
            if (sensor is IRow row)
            {
                var size = Size(sensor);
                row.WriteRow(to.GetSpan(size).Slice(0, size));
                to.Advance(size);
            }
            else to.Write(Writer.BytesOf(sensor));
        }
    }

    /// <summary>So many observations of one sensor, as one. Pictures have so many times more channels.</summary>
    public class StackingSensor : BuiltInSensor, IRow, IDisposable
    {
        private readonly ISensor wrapped;
        private readonly ObservationWriter writer = new ObservationWriter();
        private readonly byte[] rows;
        private readonly int size;

        /// <summary>Around a sensor.</summary>
        /// <exception cref="UnityAgentsException">It is no vector and no picture.</exception>
        public StackingSensor(ISensor wrapped, int numStackedObservations)
            : base($"StackingSensor_size{numStackedObservations}_{Require.Given("wrapped", wrapped).GetName()}",
                Stacked(wrapped, numStackedObservations))
        {
            this.wrapped = wrapped;
            size = SensorRows.Size(wrapped);
            rows = new byte[size * numStackedObservations];
        }

        bool IRow.IsPicture => SensorRows.IsPicture(wrapped);

        public override int Write(ObservationWriter writer)
        {
            Look();
            var seen = GetStackedObservations();
            writer.AddList(seen);
            return seen.Count;
        }

        void IRow.WriteRow(Span<byte> to)
        {
            Look();
            rows.CopyTo(to);
        }

        public override void Update()
        {
            wrapped.Update();
            Array.Copy(rows, size, rows, 0, rows.Length - size);
        }

        public override void Reset()
        {
            wrapped.Reset();
            Array.Clear(rows, 0, rows.Length);
        }

        public void Dispose() => (wrapped as IDisposable)?.Dispose();

        // A sensor alone, or in a stack.
        internal static ISensor Of(ISensor sensor, int stacks) =>
            stacks > 1 ? new StackingSensor(sensor, stacks) : sensor;

        // As they were sent last.
        internal ReadOnlyCollection<float> GetStackedObservations() => Array.AsReadOnly(SensorRows.IsPicture(wrapped)
            ? Array.ConvertAll(rows, one => one / 255f) : MemoryMarshal.Cast<byte, float>(rows).ToArray());

        private void Look()
        {
            var last = rows.AsSpan(rows.Length - size);
            if (wrapped is IRow row) row.WriteRow(last);
            else writer.BytesOf(wrapped).CopyTo(last);
        }

        private static ObservationSpec Stacked(ISensor one, int count)
        {
            var spec = one.GetObservationSpec();
            if (spec.Rank != 1 && spec.Rank != 3)
                throw new UnityAgentsException($"{one.GetName()} cannot be stacked: only vectors and pictures can");
            var shape = (int[])spec.Shape.Clone();
            shape[0] *= count;
            return new ObservationSpec(shape, spec.DimensionProperties, spec.ObservationType);
        }
    }

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
