// ML-Agents' shape, [Observable]: fields and properties of an agent that it sees, where Behavior Parameters says so.
//
//     [Observable] private float speed;                     a sensor of one number
//     [Observable(numStackedObservations: 3)] Vector3 Way => transform.forward;
using System;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using UnityEngine;

namespace NetMQExample.MLAgents.Sensors.Reflection
{
    /// <summary>A member that an agent sees: int, bool, float, Vector2 to Vector4, Quaternion or an enum.</summary>
    [AttributeUsage(AttributeTargets.Field | AttributeTargets.Property)]
    public class ObservableAttribute : Attribute
    {
        /// <summary>With the name of its sensor, and how many observations go together.</summary>
        public ObservableAttribute(string name = null, int numStackedObservations = 1) =>
            (Name, Stacks) = (name, numStackedObservations);

        internal string Name { get; }
        internal int Stacks { get; }
    }

    /// <summary>The sensor of one member.</summary>
    internal sealed class ObservableSensor : BuiltInSensor
    {
        private const BindingFlags Any = BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic;
        private readonly Func<object> read;

        private ObservableSensor(string name, int size, Func<object> read) : base(name, ObservationSpec.Vector(size)) =>
            this.read = read;

        public static IEnumerable<ISensor> Of(object agent, bool ownOnly)
        {
            var which = ownOnly ? Any | BindingFlags.DeclaredOnly : Any;
            var type = agent.GetType();
            var fields = type.GetFields(which).Select(one => Of(one, one.FieldType, true, () => one.GetValue(agent)));
            var properties = type.GetProperties(which)
                .Select(one => Of(one, one.PropertyType, one.CanRead, () => one.GetValue(agent)));
            return fields.Concat(properties).Where(sensor => sensor != null);
        }

        public override int Write(ObservationWriter writer)
        {
            var numbers = Numbers(read());
            foreach (var number in numbers) UnityAgentsException.Finite(number, GetName());
            writer.AddList(numbers);
            return numbers.Length;
        }

        private static ISensor Of(MemberInfo member, Type type, bool canRead, Func<object> read)
        {
            var asked = member.GetCustomAttribute<ObservableAttribute>();
            if (asked == null) return null;
            var place = $"{member.DeclaringType.Name}.{member.Name}";
            var name = string.IsNullOrEmpty(asked.Name) ? $"ObservableAttribute:{place}" : asked.Name;
            var numbers = canRead && type.IsValueType ? Numbers(Activator.CreateInstance(type)) : null;
            if (numbers != null)
                return StackingSensor.Of(new ObservableSensor(name, numbers.Length, read), asked.Stacks);
            Debug.LogError($"[Observable] {place} cannot be seen: give it a getter, and one of the types int, "
                + "bool, float, Vector2, Vector3, Vector4, Quaternion or an enum");
            return null;
        }

        private static float[] Numbers(object value) => value switch
        {
            int number => new float[] { number },
            bool flag => new float[] { flag ? 1 : 0 },
            float number => new[] { number },
            Enum choice =>
                Enum.GetValues(choice.GetType()).Cast<Enum>().Select(one => Has(choice, one) ? 1f : 0).ToArray(),
            _ => UnityValues.Numbers(value) as float[],
        };

        private static bool Has(Enum choice, Enum one) =>
            choice.GetType().IsDefined(typeof(FlagsAttribute), false) ? choice.HasFlag(one) : choice.Equals(one);
    }
}
