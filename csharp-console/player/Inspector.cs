// Serialized fields by name, as the inspector shows them and --set endpoint=… sets them.
using System;
using System.Collections.Generic;
using System.ComponentModel;
using System.Globalization;
using System.Linq;
using System.Reflection;
using UnityEngine;

namespace UnityPlayer
{
    public static class Inspector
    {
        /// <summary>The fields that Unity serializes: public ones, and private ones with [SerializeField].</summary>
        public static IEnumerable<FieldInfo> Fields(Type script)
        {
            const BindingFlags own = BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic | BindingFlags.DeclaredOnly;
            for (var type = script; type != null && type != typeof(MonoBehaviour); type = type.BaseType)
                foreach (var field in type.GetFields(own))
                    if (!field.IsInitOnly && !field.IsNotSerialized && (field.IsPublic || field.IsDefined(typeof(SerializeField))))
                        yield return field;
        }

        /// <summary>Sets a field of every script that has it.</summary>
        /// <exception cref="ArgumentException">No script has it, or the text is no such value; the message says what is.</exception>
        public static void Set(IReadOnlyCollection<MonoBehaviour> scripts, string name, string text)
        {
            var found = false;
            foreach (var script in scripts)
                foreach (var field in Fields(script.GetType()).Where(field => field.Name == name))
                {
                    field.SetValue(script, Parse(field, text));
                    found = true;
                }
            if (found) return;
            var known = scripts.SelectMany(script => Fields(script.GetType())).Select(field => field.Name).Distinct();
            throw new ArgumentException($"--set {name}: there is no such field; there are: {string.Join(" ", known)}");
        }

        private static object Parse(FieldInfo field, string text)
        {
            try
            {
                return TypeDescriptor.GetConverter(field.FieldType).ConvertFromString(null, CultureInfo.InvariantCulture, text);
            }
            // Converters wrap what goes wrong in a plain Exception, differently on each runtime.
            catch (Exception e) when (!(e is OutOfMemoryException))
            {
                throw new ArgumentException($"--set {field.Name}: '{text}' is no {field.FieldType.Name}");
            }
        }
    }
}
