// ML-Agents' shape, [Observable]: fields and properties of an agent that it sees, where Behavior Parameters says so.
//
//     [Observable] private float speed;                     a sensor of one number
//     [Observable(numStackedObservations: 3)] Vector3 Way => transform.forward;
using System;
using System.Collections.Generic;
using System.Reflection;
using UnityEngine;

namespace NetMQExample.MLAgents.Sensors.Reflection
{
    /// <summary>A member that an agent sees: int, bool, float, Vector2 to Vector4, Quaternion or an enum.</summary>
    [AttributeUsage(AttributeTargets.Field | AttributeTargets.Property)]
    public class ObservableAttribute : Attribute
    {
        /// <summary>With the name of its sensor, and how many observations go together.</summary>
        public ObservableAttribute(string name = null, int numStackedObservations = 1)
        {
            Name = name;
            Stacks = numStackedObservations;
        }

        internal string Name { get; }

        internal int Stacks { get; }
    }

    /// <summary>The sensor of one member.</summary>
    internal sealed class ObservableSensor : ISensor
    {
        private const BindingFlags Any = BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic;
        private readonly Func<object> read;
        private readonly Array values;
        private readonly bool isFlags;
        private readonly VectorSensor numbers;

        private ObservableSensor(string name, Type type, Func<object> read)
        {
            this.read = read;
            values = type.IsEnum ? Enum.GetValues(type) : null;
            isFlags = type.IsDefined(typeof(FlagsAttribute), false);
            numbers = new VectorSensor(SizeOf(type), name);
        }

        public static IEnumerable<ISensor> Of(object agent, bool ownOnly)
        {
            var which = ownOnly ? Any | BindingFlags.DeclaredOnly : Any;
            foreach (var field in agent.GetType().GetFields(which))
                if (Of(field, field.FieldType, () => field.GetValue(agent)) is ISensor sensor) yield return sensor;
            foreach (var property in agent.GetType().GetProperties(which))
                if (Of(property, property.PropertyType, () => property.GetValue(agent)) is ISensor sensor)
                    yield return sensor;
        }

        public int Write(ObservationWriter writer)
        {
            numbers.Update();
            Add(read());
            return numbers.Write(writer);
        }

        public void Update() { }

        public void Reset() { }

        public ObservationSpec GetObservationSpec() => numbers.GetObservationSpec();

        public string GetName() => numbers.GetName();

        public byte[] GetCompressedObservation() => null;

        public CompressionSpec GetCompressionSpec() => CompressionSpec.Default();

        private static ISensor Of(MemberInfo member, Type type, Func<object> read)
        {
            var asked = member.GetCustomAttribute<ObservableAttribute>();
            if (asked == null) return null;
            var place = $"{member.DeclaringType.Name}.{member.Name}";
            if (SizeOf(type) == 0 || member is PropertyInfo property && !property.CanRead)
            {
                Debug.LogError($"[Observable] {place} cannot be seen: give it a getter, and one of the types int, bool, "
                    + "float, Vector2, Vector3, Vector4, Quaternion or an enum");
                return null;
            }
            var name = string.IsNullOrEmpty(asked.Name) ? $"ObservableAttribute:{place}" : asked.Name;
            return StackingSensor.Of(new ObservableSensor(name, type, read), asked.Stacks);
        }

        private static int SizeOf(Type type) =>
            type.IsEnum ? Enum.GetValues(type).Length
            : type == typeof(int) || type == typeof(bool) || type == typeof(float) ? 1
            : type == typeof(Vector2) ? 2
            : type == typeof(Vector3) ? 3
            : type == typeof(Vector4) || type == typeof(Quaternion) ? 4 : 0;

        private void Add(object value)
        {
            switch (value)
            {
                case int number: numbers.AddObservation(number); break;
                case bool flag: numbers.AddObservation(flag); break;
                case float number: numbers.AddObservation(number); break;
                case Vector2 vector: numbers.AddObservation(vector); break;
                case Vector3 vector: numbers.AddObservation(vector); break;
                case Quaternion turn: numbers.AddObservation(turn); break;
                case Vector4 vector: numbers.AddObservation(new[] { vector.x, vector.y, vector.z, vector.w }); break;
                case Enum one:
                    foreach (Enum each in values) numbers.AddObservation(isFlags ? one.HasFlag(each) : each.Equals(one));
                    break;
            }
        }
    }
}
