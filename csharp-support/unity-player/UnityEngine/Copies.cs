// Instantiate copies game objects with their components, and with the serialized fields of their scripts.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Reflection;
using UnityPlayer;

namespace UnityEngine
{
    internal static class Copies
    {
        private static readonly MethodInfo Shallow =
            typeof(object).GetMethod("MemberwiseClone", BindingFlags.Instance | BindingFlags.NonPublic);

        /// <summary>A copy, which wakes up when it is placed.</summary>
        public static T Of<T>(T original, Action<Transform> place = null) where T : Object
        {
            MainThread.Only("Internal_CloneSingle");
            if (original == null)
                throw new ArgumentException(
                    "The Object you want to instantiate is null. (The player fills no field with a prefab: make "
                + "one by new GameObject or GameObject.CreatePrimitive.)");
            if (original is Material material) return new Material(material) as T;
            var whole = original as GameObject ?? (original as Component)?.Owner
                ?? throw new NotSupportedException("the player copies game objects, components and materials");
            var twins = new Dictionary<Object, Object>();
            var copy = Asleep(whole, twins);
            foreach (var pair in twins)
                if (pair.Key is Component from) Fill(from, pair.Value, twins);
            copy.name = $"{whole.name}(Clone)";
            place?.Invoke(copy.transform);
            copy.SetActive(whole.activeSelf);
            return (T)twins[original];
        }

        private static GameObject Asleep(GameObject whole, Dictionary<Object, Object> twins)
        {
            var copy = new GameObject(whole.name, false) { tag = whole.tag, layer = whole.layer };
            twins[whole] = copy;
            foreach (var part in whole.Components)
                twins[part] = part is Transform ? copy.transform : copy.AddComponent(part.GetType());
            var (from, to) = (whole.transform, copy.transform);
            (to.localPosition, to.localRotation, to.localScale) = (from.localPosition, from.localRotation,
                from.localScale);
            foreach (var child in from.Children)
            {
                var below = Asleep(child.Owner, twins);
                below.transform.SetParent(to, false);
                below.SetActive(child.Owner.activeSelf);
            }
            return copy;
        }

        private static void Fill(Component from, Object to, Dictionary<Object, Object> twins)
        {
            if (from is MonoBehaviour) CopyFields(from, to, twins);
            foreach (var setting in from.GetType().GetProperties())
                if (setting.DeclaringType.Assembly == typeof(Object).Assembly && setting.GetSetMethod() != null
                    && !setting.DeclaringType.IsAssignableFrom(typeof(Transform)))
                    setting.SetValue(to, setting.GetValue(from));
        }

        private static void CopyFields(object from, object to, Dictionary<Object, Object> twins)
        {
            foreach (var field in Inspector.Fields(from.GetType()))
                field.SetValue(to, Copy(field.GetValue(from), twins));
        }

        // A reference to a part of the original becomes one to the same part of the copy.
        private static object Copy(object value, Dictionary<Object, Object> twins)
        {
            if (value is Object thing) return twins.TryGetValue(thing, out var twin) ? twin : thing;
            if (value is IList list)
            {
                var items = value is Array array
                    ? (IList)array.Clone()
                    : (IList)Activator.CreateInstance(value.GetType(), value);
                for (var i = 0; i < list.Count; i++) items[i] = Copy(list[i], twins);
                return items;
            }
            if (value == null || value is string || value.GetType().IsPrimitive || !value.GetType().IsSerializable)
                return value;
            var made = Shallow.Invoke(value, null);
            CopyFields(value, made, twins);
            return made;
        }
    }
}
