// A Play's events tell this to the rest of the game, for runs with --heard: how often each was raised, and how often of
// these in the frame of the line that was logged last. And how many messages the editor's window could have shown.
using System;
using System.Collections;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Reflection;
using System.Threading;
using UnityEngine;
using UnityEngine.Events;

namespace NetMQExample.Tests
{
    internal sealed class Heard : IDisposable
    {
        private readonly List<One> events = new List<One>();
        private int frame, sent, received;

        public Heard()
        {
            Application.logMessageReceived += Look;
            NetMQConnection.Seen += See;
        }

        private void See(string endpoint, bool sent, IEnumerable frames) =>
            Interlocked.Increment(ref sent ? ref this.sent : ref received);

        // The scene is there when its first line is.
        private void Look(string line, string stack, LogType type)
        {
            frame = Time.frameCount;
            if (events.Count > 0) return;
            const BindingFlags All = BindingFlags.Static | BindingFlags.Public;
            var scene = typeof(GameObject).Assembly.GetType("UnityEngine.LoadedScene").GetProperty("Objects", All);
            foreach (var thing in (List<GameObject>)scene.GetValue(null))
                foreach (var script in thing.GetComponentsInChildren<MonoBehaviour>(true))
                {
                    foreach (var one in script.GetType().GetEvents())
                        one.AddEventHandler(script, Told(one.Name, one.EventHandlerType));
                    // And as the inspector wires them.
                    for (var own = script.GetType(); own != typeof(MonoBehaviour); own = own.BaseType)
                        foreach (var field in own.GetFields(BindingFlags.Instance | BindingFlags.NonPublic))
                            if (field.GetValue(script) is UnityEventBase wired)
                            {
                                var add = wired.GetType().GetMethod("AddListener");
                                add.Invoke(wired,
                                    new object[] { Told(field.Name, add.GetParameters()[0].ParameterType) });
                            }
                }
        }

        private Delegate Told(string name, Type handler)
        {
            events.Add(new One(this, name));
            return typeof(One).GetMethod("Tell").MakeGenericMethod(handler.GetGenericArguments())
                .CreateDelegate(handler, events[^1]);
        }

        public void Print(TextWriter output)
        {
            foreach (var one in events) output.WriteLine($"heard {one.Name} {one.Times}, {one.Beside} beside a line");
            output.WriteLine($"shown: {sent} sent, {received} received");
        }

        public void Dispose()
        {
            Application.logMessageReceived -= Look;
            NetMQConnection.Seen -= See;
        }

        private sealed class One
        {
            public readonly string Name;
            private readonly Heard all;
            public int Times, Beside;

            public One(Heard all, string name) => (this.all, Name) = (all, name);

            public void Tell<T>(T value)
            {
                Times++;
                if (all.frame == Time.frameCount) Beside++;
            }
        }
    }
}
