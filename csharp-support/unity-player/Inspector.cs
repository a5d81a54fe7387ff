// Serialized fields by name, as the inspector shows them and --endpoint … sets them.
using System;
using System.Collections;
using System.Collections.Generic;
using System.ComponentModel;
using System.Diagnostics;
using System.Globalization;
using System.IO;
using System.Linq;
using System.Reflection;
using System.Text.RegularExpressions;
using UnityEngine;
using Component = UnityEngine.Component;
using Object = UnityEngine.Object;

namespace UnityPlayer
{
    public static class Inspector
    {
        /// <summary>The fields that Unity serializes: public ones, and private ones with [SerializeField], of types
        /// that it can write into a scene.</summary>
        public static IEnumerable<FieldInfo> Fields(Type script)
        {
            const BindingFlags own = BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic
                | BindingFlags.DeclaredOnly;
            for (var type = script; type != null && type != typeof(MonoBehaviour); type = type.BaseType)
                foreach (var field in type.GetFields(own))
                    if (!field.IsInitOnly && !field.IsNotSerialized
                        && (field.IsPublic || field.IsDefined(typeof(SerializeField)))
                        && CanSerialize(field.FieldType))
                        yield return field;
        }

        /// <summary>The values of a script's fields before anybody sets them, in words.</summary>
        public static IEnumerable<(string Name, string Value)> Defaults(Type script)
        {
            var one = Activator.CreateInstance(script);
            return Fields(script)
                .Select(field => (field.Name, Convert.ToString(field.GetValue(one), CultureInfo.InvariantCulture)));
        }

        /// <summary>Sets a field of every script that has it, or, as <c>ViewRecorder.endpoint</c>, that of one
        /// class.</summary>
        /// <exception cref="ArgumentException">No script has it, or the text is no such value; the message says what
        /// is.</exception>
        public static void Set(IReadOnlyCollection<MonoBehaviour> scripts, string name, string text)
        {
            var found = false;
            // The terminal's --cancel-at is the field cancelAt.
            var written = Regex.Replace(name, "-([a-z])", letter => letter.Groups[1].Value.ToUpperInvariant());
            foreach (var script in scripts)
                foreach (var field in Fields(script.GetType())
                    .Where(field => written == field.Name || written == $"{script.GetType().Name}.{field.Name}"))
                {
                    field.SetValue(script, Parse(field, text));
                    found = true;
                }
            if (found) return;
            var known = scripts.SelectMany(script => Fields(script.GetType())).Select(field => field.Name).Distinct();
            throw new ArgumentException(
                $"unknown: --{name}; the fields that a script has here: {string.Join(" ", known)}");
        }

        /// <summary>The type of an array's or a list's items, or null.</summary>
        internal static Type Item(Type type) => type.IsArray ? type.GetElementType()
            : type.IsGenericType && type.GetGenericTypeDefinition() == typeof(List<>)
                ? type.GetGenericArguments()[0]
                : null;

        /// <summary>Whether it is a value, and no other thing that is referred to.</summary>
        internal static bool IsPlain(Type type) => type.IsPrimitive || type.IsEnum || type == typeof(string)
            || type.IsSerializable && !type.IsGenericType && !type.IsArray && !typeof(Delegate).IsAssignableFrom(type)
                && type.Namespace?.StartsWith("System") != true
            || type.IsValueType && type.Namespace == nameof(UnityEngine);

        private static bool CanSerialize(Type type) =>
            IsPlain(Item(type) ?? type) || typeof(Object).IsAssignableFrom(Item(type) ?? type);

        /// <summary>Leaves no text, array or list null: a scene file has them empty at least.</summary>
        public static void FillIn(MonoBehaviour script)
        {
            foreach (var field in Fields(script.GetType()).Where(field => field.GetValue(script) == null))
                if (field.FieldType == typeof(string)) field.SetValue(script, "");
                else if (field.FieldType.IsArray)
                    field.SetValue(script, Array.CreateInstance(field.FieldType.GetElementType(), 0));
                else if (Item(field.FieldType) != null)
                    field.SetValue(script, Activator.CreateInstance(field.FieldType));
        }

        /// <summary>A component of Unity's, or of these scripts, by its name.</summary>
        /// <exception cref="ArgumentException">There is none.</exception>
        public static Type Component(string name, params Assembly[] scripts) => Find(name, scripts)
            ?? throw new ArgumentException($"--add {name}: the player has no such component");

        private static Type Find(string name, params Assembly[] scripts) => scripts.Append(typeof(GameObject).Assembly)
            .SelectMany(assembly => assembly.GetExportedTypes()).FirstOrDefault(
                type => type.Name == name && typeof(Component).IsAssignableFrom(type) && !type.IsAbstract);

        /// <summary>An exception in words. If it comes from an empty field, these are Unity's, with the option that
        /// fills it.</summary>
        internal static string Explained(Exception e, Object context)
        {
            if (!(context is MonoBehaviour)
                || !(e is NullReferenceException || e is IndexOutOfRangeException || e is ArgumentOutOfRangeException))
                return $"{e}";
            var place = new StackTrace(e, true).GetFrames().FirstOrDefault(frame => File.Exists(frame.GetFileName()));
            var line = place == null
                ? ""
                : File.ReadLines(place.GetFileName()).ElementAtOrDefault(place.GetFileLineNumber() - 1) ?? "";
            var script = context.GetType();
            var empty = Fields(script).FirstOrDefault(field =>
                IsEmpty(field, field.GetValue(context)) && Regex.IsMatch(line, $@"\b{field.Name}\b")
                && (e is NullReferenceException) == (Item(field.FieldType) == null));
            if (empty == null) return $"{e}{Lacking((MonoBehaviour)context, place?.GetFileName())}";
            var option = $"--{script.Name}.{empty.Name}";
            return Item(empty.FieldType) == null
                ? $"UnassignedReferenceException: The variable {empty.Name} of {script.Name} has not been assigned.\n"
                    + $"You probably need to assign the {empty.Name} variable of the {script.Name} script "
                    + $"in the inspector: here by {option} NAME\n{e.StackTrace}"
                : $"{e.GetType().Name}: {e.Message} Is {empty.Name} of {script.Name} empty? "
                    + $"{option} A,B fills it, and so does {option} Point*21\n{e.StackTrace}";
        }

        // A component that the script asks for and that its object does not have.
        private static string Lacking(MonoBehaviour script, string file)
        {
            var asked = file == null ? "" : File.ReadAllText(file);
            var lacks = Regex.Matches(asked, @"(?<![\w\])]\.)(?:\bgameObject\.|\bthis\.)?\bGetComponent<(\w+)>")
                .Select(match => match.Groups[1].Value)
                .FirstOrDefault(name => script.gameObject.GetComponent(name) == null && Find(name) != null);
            return lacks == null ? "" : $"\nDoes {script.name} lack the component {lacks}? --add {lacks} gives it one";
        }

        private static bool IsEmpty(FieldInfo field, object value) =>
            typeof(Object).IsAssignableFrom(Item(field.FieldType) ?? field.FieldType)
            && (value is ICollection items ? items.Count == 0 : value as Object == null);

        // The one of this name, or that has a component of this name, or a new one. An array takes several: A,B or
        // Point*21.
        private static object Referred(Type type, string text)
        {
            if (Item(type) is Type item)
            {
                var many = Regex.Match(text, @"^(.*)\*(\d{1,4})$");
                var names = many.Success
                    ? Enumerable.Range(0, int.Parse(many.Groups[2].Value)).Select(i => $"{many.Groups[1]}{i}")
                    : text.Split(',');
                var found = names.Select(name => Referred(item, name.Trim())).ToArray();
                var array = Array.CreateInstance(item, found.Length);
                found.CopyTo(array, 0);
                return type.IsArray ? array : Activator.CreateInstance(type, array);
            }
            if (text.Length == 0 || type != typeof(GameObject) && !typeof(Component).IsAssignableFrom(type))
                throw new FormatException();
            var thing = LoadedScene.Objects.FirstOrDefault(
                    one => one.name == text || one.Components.Any(part => part.GetType().Name == text))
                ?? new GameObject(text);
            if (type == typeof(GameObject)) return thing;
            return thing.GetComponent(type)
                ?? thing.AddComponent(type == typeof(TMPro.TMP_Text) ? typeof(TMPro.TextMeshProUGUI) : type);
        }

        private static object Parse(FieldInfo field, string text)
        {
            object value;
            try
            {
                value = field.FieldType == typeof(Vector3) ? Vector(text)
                    : typeof(Object).IsAssignableFrom(Item(field.FieldType) ?? field.FieldType)
                        ? Referred(field.FieldType, text)
                    : TypeDescriptor.GetConverter(field.FieldType)
                        .ConvertFromString(null, CultureInfo.InvariantCulture, text);
            }
            // Converters wrap what goes wrong in a plain Exception, differently on each runtime.
            catch (Exception e) when (!(e is OutOfMemoryException))
            {
                var type = field.FieldType;
                var wanted = type == typeof(float) ? "number" : type == typeof(int) ? "whole number" : type.Name;
                throw new ArgumentException($"--{field.Name}: '{text}' is no {wanted}");
            }
            // The inspector of Unity does not let one type anything else.
            if (field.GetCustomAttribute<MinAttribute>() is MinAttribute least
                && !(Convert.ToSingle(value, CultureInfo.InvariantCulture) >= least.min))
                throw new ArgumentException(
                    FormattableString.Invariant($"--{field.Name}: it must be at least {least.min}, not {text}"));
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
