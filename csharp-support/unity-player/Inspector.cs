// Serialized fields by name, as the inspector shows them and --endpoint … sets them.
using System;
using System.Collections.Generic;
using System.ComponentModel;
using System.Globalization;
using System.Linq;
using System.Reflection;
using System.Text.RegularExpressions;
using UnityEngine;

namespace UnityPlayer
{
    public static class Inspector
    {
        /// <summary>The fields that Unity serializes: public ones, and private ones with [SerializeField], of types that it
        /// can write into a scene.</summary>
        public static IEnumerable<FieldInfo> Fields(Type script)
        {
            const BindingFlags own = BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic | BindingFlags.DeclaredOnly;
            for (var type = script; type != null && type != typeof(MonoBehaviour); type = type.BaseType)
                foreach (var field in type.GetFields(own))
                    if (!field.IsInitOnly && !field.IsNotSerialized && (field.IsPublic || field.IsDefined(typeof(SerializeField)))
                        && CanSerialize(field.FieldType))
                        yield return field;
        }

        /// <summary>What a script's fields have before anybody sets them, in words.</summary>
        public static IEnumerable<(string Name, string Value)> Defaults(Type script)
        {
            var one = Activator.CreateInstance(script);
            return Fields(script).Select(field => (field.Name, Convert.ToString(field.GetValue(one), CultureInfo.InvariantCulture)));
        }

        /// <summary>Sets a field of every script that has it, or, as <c>ViewRecorder.endpoint</c>, that of one class.</summary>
        /// <exception cref="ArgumentException">No script has it, or the text is no such value; the message says what is.</exception>
        public static void Set(IReadOnlyCollection<MonoBehaviour> scripts, string name, string text)
        {
            var found = false;
            // The terminal's --cancel-at is the field cancelAt.
            var written = Regex.Replace(name, "-([a-z])", letter => letter.Groups[1].Value.ToUpperInvariant());
            foreach (var script in scripts)
                foreach (var field in Fields(script.GetType()).Where(field => written == field.Name || written == $"{script.GetType().Name}.{field.Name}"))
                {
                    field.SetValue(script, Parse(field, text));
                    found = true;
                }
            if (found) return;
            var known = scripts.SelectMany(script => Fields(script.GetType())).Select(field => field.Name).Distinct();
            throw new ArgumentException($"unknown: --{name}; the fields that a script has here: {string.Join(" ", known)}");
        }

        /// <summary>What an array or a list holds, or null.</summary>
        internal static Type Item(Type type) => type.IsArray ? type.GetElementType()
            : type.IsGenericType && type.GetGenericTypeDefinition() == typeof(List<>) ? type.GetGenericArguments()[0] : null;

        /// <summary>Whether it is a value, and no other thing that is referred to.</summary>
        internal static bool IsPlain(Type type) => type.IsPrimitive || type.IsEnum || type == typeof(string)
            || type.IsSerializable && !type.IsGenericType && !type.IsArray && !typeof(Delegate).IsAssignableFrom(type) && type.Namespace?.StartsWith("System") != true
            || type.IsValueType && type.Namespace == nameof(UnityEngine);

        private static bool CanSerialize(Type type) => IsPlain(Item(type) ?? type) || typeof(UnityEngine.Object).IsAssignableFrom(Item(type) ?? type);

        private static object Parse(FieldInfo field, string text)
        {
            object value;
            try
            {
                value = field.FieldType == typeof(Vector3) ? Vector(text)
                    : TypeDescriptor.GetConverter(field.FieldType).ConvertFromString(null, CultureInfo.InvariantCulture, text);
            }
            // Converters wrap what goes wrong in a plain Exception, differently on each runtime.
            catch (Exception e) when (!(e is OutOfMemoryException))
            {
                var type = field.FieldType;
                var wanted = type == typeof(float) ? "number" : type == typeof(int) ? "whole number" : type.Name;
                throw new ArgumentException($"--{field.Name}: '{text}' is no {wanted}");
            }
            // The inspector of Unity does not let one type anything else.
            if (field.GetCustomAttribute<MinAttribute>() is MinAttribute least && !(Convert.ToSingle(value, CultureInfo.InvariantCulture) >= least.min))
                throw new ArgumentException(FormattableString.Invariant($"--{field.Name}: it must be at least {least.min}, not {text}"));
            return value;
        }

        // Unity's own have no converter. Written as 1,-0.5,0.
        private static Vector3 Vector(string text)
        {
            var n = text.Split(',').Select(word => float.Parse(word, CultureInfo.InvariantCulture)).ToArray();
            return n.Length == 3 ? new Vector3(n[0], n[1], n[2]) : throw new FormatException();
        }
    }
}
