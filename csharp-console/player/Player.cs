// One Play, as pressing the button in the editor makes it: the load methods, the scene, frames, and Stop.
// The order of events is the one of Unity's manual, "Order of execution for event functions".
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Linq;
using System.Reflection;
using System.Threading;
using UnityEngine;
using Debug = UnityEngine.Debug;

namespace UnityPlayer
{
    /// <summary>Make it, call <see cref="Begin"/>, <see cref="Frame"/> and <see cref="Stop"/> on one thread.</summary>
    public sealed class Player
    {
        private static readonly TimeSpan FrameTime = TimeSpan.FromSeconds(1 / 60.0);
        private static readonly RuntimeInitializeLoadType[] BeforeTheScene =
        {
            RuntimeInitializeLoadType.SubsystemRegistration, RuntimeInitializeLoadType.AfterAssembliesLoaded,
            RuntimeInitializeLoadType.BeforeSplashScreen, RuntimeInitializeLoadType.BeforeSceneLoad,
        };

        private readonly Assembly[] assemblies;
        private readonly Stopwatch clock = new Stopwatch();
        private readonly FrameContext context = new FrameContext();
        private SynchronizationContext contextBefore;
        private int errorsBefore;
        private double fixedTime;

        /// <param name="assemblies">Those with the scripts, whose RuntimeInitializeOnLoadMethods are called.</param>
        public Player(params Assembly[] assemblies) => this.assemblies = assemblies;

        /// <summary>How often something called Debug.LogError or threw in this Play.</summary>
        public int Errors => Debug.Errors - errorsBefore;

        /// <summary>True once a script called Application.Quit, or every component with a Done property says true.</summary>
        public bool Done
        {
            get
            {
                if (Application.QuitAsked) return true;
                var said = Behaviours().Select(DoneOf).Where(done => done != null).ToArray();
                return said.Length > 0 && said.All(done => done == true);
            }
        }

        /// <summary>Starts the Play.</summary>
        /// <param name="scene">Makes the game objects; their Awake and OnEnable are called before it returns.</param>
        public void Begin(Action scene)
        {
            MainThread.Id = Environment.CurrentManagedThreadId;
            contextBefore = SynchronizationContext.Current;
            SynchronizationContext.SetSynchronizationContext(context);
            errorsBefore = Debug.Errors;
            fixedTime = Time.Now = Time.Elapsed = Time.Frames = 0;
            Time.Clock = () => clock.Elapsed.TotalSeconds;
            Application.QuitAsked = false;
            Application.Playing = true;
            foreach (var moment in BeforeTheScene) CallLoadMethods(moment);
            scene();
            CallLoadMethods(RuntimeInitializeLoadType.AfterSceneLoad);
            clock.Restart();
        }

        /// <summary>One frame, without the wait for the next.</summary>
        public void Frame()
        {
            Time.Frames++;
            Time.Elapsed = clock.Elapsed.TotalSeconds - Time.Now;
            Time.Now += Time.Elapsed;
            ForEach(script => script.BeginFrame());
            for (; fixedTime <= Time.Now; fixedTime += Time.fixedDeltaTime) ForEach(script => script.Tick("FixedUpdate"));
            ForEach(script => script.Tick("Update"));
            context.Run();
            ForEach(script => script.Tick("LateUpdate"));
            Scene.RemoveDoomed();
        }

        /// <summary>Frames at 60 a second until everything is done, the time is over or somebody asks to stop.</summary>
        public void Run(TimeSpan limit, Func<bool> stopAsked)
        {
            for (var next = clock.Elapsed; clock.Elapsed < limit && !stopAsked(); next += FrameTime)
            {
                Frame();
                if (Done) return;
                var rest = next + FrameTime - clock.Elapsed;
                if (rest > TimeSpan.Zero) Thread.Sleep(rest);
                // A frame that took too long is not made up for by a burst of short ones.
                else next = clock.Elapsed - FrameTime;
            }
        }

        /// <summary>Ends the Play.</summary>
        /// <returns>How long the main thread, and so the editor, was busy with it.</returns>
        public TimeSpan Stop()
        {
            var busy = Stopwatch.StartNew();
            ForEach(script => script.Send("OnApplicationQuit"));
            Application.SayQuitting();
            while (Scene.Objects.Count > 0) Scene.Remove(Scene.Objects[0]);
            Scene.Doomed.Clear();
            Application.Playing = false;
            SynchronizationContext.SetSynchronizationContext(contextBefore);
            return busy.Elapsed;
        }

        private static bool? DoneOf(MonoBehaviour script) => (bool?)script.GetType().GetProperty("Done", typeof(bool))?.GetValue(script);

        private static IEnumerable<MonoBehaviour> Behaviours() => Scene.Objects.SelectMany(thing => thing.Components).OfType<MonoBehaviour>();

        // By index, because a script may add or remove others, and because a frame should allocate nothing.
        private static void ForEach(Action<MonoBehaviour> call)
        {
            for (var i = 0; i < Scene.Objects.Count; i++)
            {
                var parts = Scene.Objects[i].Components;
                for (var k = 0; k < parts.Count; k++)
                    if (parts[k] is MonoBehaviour script) call(script);
            }
        }

        private void CallLoadMethods(RuntimeInitializeLoadType moment)
        {
            const BindingFlags any = BindingFlags.Static | BindingFlags.Public | BindingFlags.NonPublic;
            foreach (var method in assemblies.SelectMany(assembly => assembly.GetTypes()).SelectMany(type => type.GetMethods(any)))
                if (method.GetCustomAttribute<RuntimeInitializeOnLoadMethodAttribute>()?.loadType == moment)
                    method.Invoke(null, null);
        }
    }
}
