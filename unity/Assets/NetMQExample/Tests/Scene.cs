// The tests of every client put it on an object, wait for it, and see what is left of it.
using System;
using System.Collections;
using System.Diagnostics;
using System.Reflection;
using NUnit.Framework;
using UnityEngine;
using Object = UnityEngine.Object;

namespace NetMQExample.Tests
{
    internal static class Scene
    {
        private const BindingFlags Own =
            BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic | BindingFlags.DeclaredOnly;

        /// <summary>An object with this component, whose every endpoint is the one given.</summary>
        /// <param name="beside">One that it needs, or null.</param>
        /// <param name="fields">Other fields to set, if it has them.</param>
        public static MonoBehaviour Play(
            Type client, Type beside, string endpoint, params (string Name, object Value)[] fields)
        {
            var thing = new GameObject(client.Name);
            // Switched off, so that the fields are set before the component wakes up.
            thing.SetActive(false);
            var component = (MonoBehaviour)thing.AddComponent(client);
            if (beside != null) thing.AddComponent(beside);
            for (var type = client; type != typeof(MonoBehaviour); type = type.BaseType)
                foreach (var field in type.GetFields(Own))
                {
                    if (field.GetValue(component) is string text && text.Contains("://127.0.0.1:"))
                        field.SetValue(component, endpoint);
                    foreach (var (name, value) in fields)
                        if (name == field.Name) field.SetValue(component, value);
                }
            thing.SetActive(true);
            return component;
        }

        // By time and not by frames: with -batchmode there are thousands a second.
        public static IEnumerator Until(Func<bool> there, string what)
        {
            var time = Stopwatch.StartNew();
            while (!there() && time.Elapsed.TotalSeconds < 10) yield return null;
            Assert.That(there(), $"not within 10 s: {what}");
        }

        /// <summary>Removes it at once, and waits until its threads and sockets are gone.</summary>
        public static IEnumerator End(MonoBehaviour client)
        {
            var busy = Stopwatch.StartNew();
            Object.DestroyImmediate(client.gameObject);
            // It tells its thread to end, and may wait 200 ms for that.
            Assert.That(busy.ElapsedMilliseconds, Is.LessThan(1000), "it made the main thread wait");
            return Until(() => NetMQLifetime.Users == 0, "nobody uses NetMQ any more");
        }
    }
}
