// One Play, as pressing the button in the editor makes it: the load methods, the scene, frames, and Stop.
// The order of events is the one of Unity's manual, "Order of execution for event functions".
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Linq;
using System.Reflection;
using System.Threading;
using UnityEngine;
using UnityEngine.Rendering;
using UnityEngine.SceneManagement;
using UnityEngine.UI;
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
        private double clockBefore, fixedTime;

        /// <param name="assemblies">Those with the scripts, whose RuntimeInitializeOnLoadMethods are called.</param>
        public Player(params Assembly[] assemblies) => this.assemblies = assemblies;
        /// <summary>How often something called Debug.LogError or threw in this Play.</summary>
        public int Errors => Debug.Errors - errorsBefore;

        /// <summary>The shaders of a game that URP draws; null: the built-in pipeline draws it.</summary>
        public static string[] UrpShaders
        {
            set
            {
                GraphicsSettings.currentRenderPipeline = value == null ? null : new Urp();
                Shader.All = value ?? Shader.All;
            }
        }

        /// <summary>What is pressed on the keyboard.</summary>
        public static void Press(float horizontal, float vertical, params KeyCode[] keys)
        {
            (Input.Horizontal, Input.Vertical) = (horizontal, vertical);
            Input.Down.Clear();
            Input.Down.UnionWith(keys);
            Input.Down.ExceptWith(Input.Pressed);
            Input.Up.Clear();
            Input.Up.UnionWith(Input.Pressed);
            Input.Up.ExceptWith(keys);
            Input.Pressed.Clear();
            Input.Pressed.UnionWith(keys);
        }

        /// <summary>The textures that nobody has destroyed, and the materials with their colours.</summary>
        public static IEnumerable<string> Left =>
            LoadedScene.Made.Select(thing => thing.GetType().Name + (thing is Material paint
            ? FormattableString.Invariant($":{paint.color.r:F2},{paint.color.g:F2},{paint.color.b:F2}") : ""));

        /// <summary>One click a second in Run: the name of a button or of a toggle, <c>Volume=0.5</c> for a slider,
        /// <c>Name=Ada</c> for an input field, or a script's method, as the inspector wires one to a button.</summary>
        public Queue<string> Clicks { get; } = new Queue<string>();

        /// <summary>The text that OnGUI has drawn last.</summary>
        public static string Drawn => GUI.Drawn;
        /// <summary>The picture that OnGUI has drawn last.</summary>
        public static Texture Picture => GUI.Picture;

        /// <summary>True once a script called Application.Quit, or every component with a Done property says
        /// true.</summary>
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
            fixedTime = clockBefore = Time.Now = Time.Unscaled = Time.Elapsed = Time.Frames = 0;
            Time.Clock = () => clock.Elapsed.TotalSeconds;
            Time.BackToNormal();
            Application.QuitAsked = false;
            Application.Playing = true;
            foreach (var moment in BeforeTheScene) CallLoadMethods(moment);
            SceneManager.Make = scene;
            scene();
            CallLoadMethods(RuntimeInitializeLoadType.AfterSceneLoad);
            Tell("OnApplicationFocus", true);
            Tell("OnApplicationPause", false);
            clock.Restart();
        }

        /// <summary>One frame, without the wait for the next.</summary>
        public void Frame()
        {
            Time.Frames++;
            SceneManager.Change();
            Time.Elapsed = clock.Elapsed.TotalSeconds - clockBefore;
            Time.Unscaled = clockBefore += Time.Elapsed;
            // Capped: after a long frame the game's time is behind, and FixedUpdate does not have to catch up for ever.
            Time.Now += Time.deltaTime;
            AsyncGPUReadback.NextFrame();
            ForEach(script => script.BeginFrame());
            for (; fixedTime <= Time.Now; fixedTime += Time.fixedDeltaTime)
            {
                Time.Fixed = fixedTime;
                ForEach(script => script.Tick("FixedUpdate"));
                if (Physics.simulationMode == SimulationMode.FixedUpdate) Contacts.Step(Time.fixedDeltaTime);
                Coroutine.Run(typeof(WaitForFixedUpdate));
            }
            Time.Fixed = null;
            ForEach(script => script.Tick("Update"));
            Coroutine.Run(null);
            context.Run();
            // A script that was made in an Update starts in the same frame.
            ForEach(script => script.BeginFrame());
            ForEach(script => script.Tick("LateUpdate"));
            ForEach(script => script.Tick("OnGUI"));
            Coroutine.Run(typeof(WaitForEndOfFrame));
            Input.Down.Clear();
            Input.Up.Clear();
            LoadedScene.RemoveDestroyed();
        }

        // Where neither says anything, frames come as fast as they can.
        private static TimeSpan FrameLength =>
            Application.targetFrameRate > 0 ? TimeSpan.FromSeconds(1.0 / Application.targetFrameRate)
            : QualitySettings.VSyncs > 0 ? FrameTime * QualitySettings.VSyncs : TimeSpan.Zero;

        /// <summary>Frames at 60 a second, or at targetFrameRate, until the time is over, somebody asks to stop, a
        /// script calls Application.Quit or, unless the caller wants all of the time, every script is done.</summary>
        public void Run(TimeSpan limit, Func<bool> stopAsked, bool untilDone = true)
        {
            var nextClick = TimeSpan.FromSeconds(1);
            for (var next = clock.Elapsed; clock.Elapsed < limit && !stopAsked(); next += FrameLength)
            {
                if (Clicks.Count > 0 && clock.Elapsed > nextClick)
                {
                    nextClick += TimeSpan.FromSeconds(1);
                    Click(Clicks.Dequeue());
                }
                Frame();
                if (Application.QuitAsked || (untilDone && Done)) return;
                var rest = next + FrameLength - clock.Elapsed;
                if (rest > TimeSpan.Zero) Thread.Sleep(rest);
                // A frame that took too long is not made up for by a burst of short ones.
                else next = clock.Elapsed - FrameLength;
            }
        }

        /// <summary>Sends a game out of sight and back, as a phone does.</summary>
        public void Pause(bool paused) => Tell("OnApplicationPause", paused);

        /// <summary>Does as the editor does when a script was changed while playing, without the reload
        /// itself.</summary>
        public TimeSpan Recompile()
        {
            var busy = Stopwatch.StartNew();
            UnityEditor.AssemblyReloadEvents.SayReloading();
            foreach (var script in Behaviours().ToArray()) script.enabled = false;
            var took = busy.Elapsed;
            foreach (var script in Behaviours().ToArray()) script.enabled = true;
            return took;
        }

        /// <summary>Ends the Play.</summary>
        /// <returns>How long the main thread, and so the editor, was busy with it.</returns>
        public TimeSpan Stop()
        {
            var busy = Stopwatch.StartNew();
            ForEach(script => script.Send("OnApplicationQuit"));
            Application.SayQuitting();
            while (LoadedScene.Objects.Count > 0) LoadedScene.Remove(LoadedScene.Objects[0]);
            LoadedScene.RemoveDestroyed();
            Contacts.Clear();
            Debug.SayRepeated();
            Application.Playing = false;
            SynchronizationContext.SetSynchronizationContext(contextBefore);
            return busy.Elapsed;
        }

        private static bool? DoneOf(MonoBehaviour script) =>
            (bool?)script.GetType().GetProperty("Done", typeof(bool))?.GetValue(script);
        private static IEnumerable<MonoBehaviour> Behaviours() =>
            LoadedScene.Objects.SelectMany(thing => thing.Components).OfType<MonoBehaviour>();

        private static void Click(string text)
        {
            var words = text.Split('=', 2);
            var ui = LoadedScene.Active.Where(one => one.name == words[0]).Select(one => one.GetComponent<Selectable>())
                .FirstOrDefault(one => one != null);
            var script = Behaviours().FirstOrDefault(one => one.Can(words[0]));
            try
            {
                if (ui != null) ui.Click(words.Length > 1 ? words[1] : "");
                else if (script != null) script.Call(words[0]);
                else
                    Debug.LogError($"--click {text}: no button, toggle, slider or input field has this name, "
                        + "and no script such a method");
            }
            catch (FormatException)
            {
                Debug.LogError($"--click {text}: a slider takes a number, such as {words[0]}=0.5");
            }
            catch (Exception e) { Debug.LogException(e); }
        }

        // By index, because a script may add or remove others, and because a frame should allocate nothing.
        private static void ForEach(Action<MonoBehaviour> call)
        {
            var orders = MonoBehaviour.Orders;
            for (var order = 0; order < orders.Count; order++)
                for (var i = 0; i < LoadedScene.Objects.Count; i++)
                {
                    var parts = LoadedScene.Objects[i].Components;
                    for (var k = 0; k < parts.Count; k++)
                        if (parts[k] is MonoBehaviour script && script.Order == orders[order]) call(script);
                }
        }

        private static void Tell(string message, bool value) => ForEach(script => script.Tell(message, value));

        private void CallLoadMethods(RuntimeInitializeLoadType moment)
        {
            const BindingFlags any = BindingFlags.Static | BindingFlags.Public | BindingFlags.NonPublic;
            foreach (var method in assemblies.SelectMany(assembly => assembly.GetTypes())
                .SelectMany(type => type.GetMethods(any)))
                if (method.GetCustomAttribute<RuntimeInitializeOnLoadMethodAttribute>()?.loadType == moment)
                    method.Invoke(null, null);
        }

        private sealed class Urp : RenderPipelineAsset { }
    }
}
