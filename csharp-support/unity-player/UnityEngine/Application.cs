// The running game as a whole: its switches, its clock and its log.
using System;
using System.Collections.Concurrent;
using System.Linq;
using System.Runtime.InteropServices;
using System.Threading;
using UnityPlayer;

namespace UnityEditor
{
    public static class AssemblyReloadEvents
    {
        public delegate void AssemblyReloadCallback();
        public static event AssemblyReloadCallback beforeAssemblyReload;
        internal static void SayReloading() => beforeAssemblyReload?.Invoke();
    }

    public enum PlayModeStateChange
    {
        EnteredEditMode,
        ExitingEditMode,
    }

    public sealed class EditorApplication
    {
        public static CallbackFunction update;

        public delegate void CallbackFunction();

        public static event Action quitting;
        public static event Action<PlayModeStateChange> playModeStateChanged;
        private static bool playing;

        // Setting it presses the button: the Play ends with this frame.
        public static bool isPlaying
        {
            get => playing || UnityEngine.Application.Playing;
            set
            {
                playing = value;
                UnityEngine.Application.QuitAsked |= !value;
            }
        }

        internal static void SayQuitting() => quitting?.Invoke();
        internal static void Say(PlayModeStateChange state) => playModeStateChanged?.Invoke(state);
    }
}

namespace UnityEngine
{
    public enum RuntimePlatform
    {
        OSXEditor = 0, OSXPlayer = 1, WindowsPlayer = 2, WindowsEditor = 7, LinuxPlayer = 13, LinuxEditor = 16,
    }

    public enum LogType { Error, Assert, Warning, Log, Exception }

    public class Application
    {
        // As ProjectSettings.asset of unity/ has it.
        private static bool background = true;
        public delegate void LogCallback(string condition, string stackTrace, LogType type);
        public static event LogCallback logMessageReceived;
        public static event Action quitting;
        internal static bool QuitAsked { get; set; }
        internal static bool Playing { get; set; }
        internal static bool Mobile { get; set; }
        internal static bool Editor { get; set; }
        public static bool isEditor => Editor;
        public static bool isMobilePlatform => Mobile;
        public static bool isPlaying => MainThread.Of("get_isPlaying", Playing);
        // Where the player was started; Unity has a folder of the user's for each game.
        public static string persistentDataPath =>
            MainThread.Of("get_persistentDataPath", Environment.CurrentDirectory);
        public static string dataPath => MainThread.Of("get_dataPath", Environment.CurrentDirectory);
        public static RuntimePlatform platform =>
            RuntimeInformation.IsOSPlatform(OSPlatform.Windows) ? RuntimePlatform.WindowsPlayer
            : RuntimeInformation.IsOSPlatform(OSPlatform.OSX) ? RuntimePlatform.OSXPlayer : RuntimePlatform.LinuxPlayer;

        public static bool runInBackground
        {
            get => MainThread.Of("get_runInBackground", background);
            set => background = MainThread.Of("set_runInBackground", value);
        }

        // Unity's own: as it likes.
        public static int targetFrameRate { get; set; } = -1;

        public static void Quit()
        {
            MainThread.Only(nameof(Quit));
            QuitAsked = true;
        }

        internal static void SayQuitting() => quitting?.Invoke();

        // Unity too calls it on the main thread only; what is logged elsewhere goes to logMessageReceivedThreaded.
        internal static void SayLogged(string text, LogType type)
        {
            if (MainThread.IsThis) logMessageReceived?.Invoke(text, "", type);
        }
    }

    public class Time
    {
        private static float step = 0.02f;
        internal static double Now { get; set; }
        internal static double Elapsed { get; set; }
        internal static double Unscaled { get; set; }
        internal static double? Fixed { get; set; }
        internal static int Frames { get; set; }
        internal static Func<double> Clock { get; set; } = () => 0;
        public static float timeScale { get; set; } = 1;
        // More than 0: each frame is so many seconds of the game's time, or so many frames a second.
        public static float captureDeltaTime { get; set; }
        public static int captureFramerate
        {
            get => captureDeltaTime == 0 ? 0 : (int)Math.Round(1 / captureDeltaTime);
            set => captureDeltaTime = value == 0 ? 0 : 1f / value;
        }
        // In FixedUpdate both are those of the step.
        public static float time => (float)Checked("get_time", Fixed ?? Now);
        public static float deltaTime =>
            (float)Checked("get_deltaTime", Fixed == null ? OfThisFrame * timeScale : step);
        public static float unscaledTime => (float)Checked("get_unscaledTime", Unscaled);
        public static float unscaledDeltaTime => (float)Checked("get_unscaledDeltaTime", Elapsed);
        // A new project has a third of a second.
        public static float maximumDeltaTime => (float)Checked("get_maximumDeltaTime", 1 / 3.0);
        public static float fixedDeltaTime
        {
            get => (float)Checked("get_fixedDeltaTime", step);
            set => step = Math.Max(value, 0.0001f);
        }
        public static float realtimeSinceStartup => (float)Checked("get_realtimeSinceStartup", Clock());
        public static int frameCount => (int)Checked("get_frameCount", Frames);
        private static double OfThisFrame =>
            captureDeltaTime > 0 ? captureDeltaTime : Math.Min(Elapsed, maximumDeltaTime);
        internal static void BackToNormal() =>
            (timeScale, captureDeltaTime, step, Application.targetFrameRate, QualitySettings.VSyncs) =
                (1, 0, 0.02f, -1, 1);

        private static double Checked(string api, double value)
        {
            MainThread.Only(api);
            return value;
        }
    }

    public sealed class Screen
    {
        // There is no window here: a small one is imagined.
        public static int width => 640;
        public static int height => 480;
        public static void SetResolution(int width, int height, bool fullscreen) =>
            MainThread.Only(nameof(SetResolution));
    }

    public sealed class QualitySettings : Object
    {
        private static int vSyncs = 1;
        private QualitySettings() { }
        // How many times the screen is drawn for each frame; 0: frames do not wait for it.
        public static int vSyncCount
        {
            get => MainThread.Of("get_vSyncCount", vSyncs);
            set => vSyncs = MainThread.Of("set_vSyncCount", value);
        }
        internal static int VSyncs { get => vSyncs; set => vSyncs = value; }
        public static void SetQualityLevel(int index, bool applyExpensiveChanges) =>
            MainThread.Only(nameof(SetQualityLevel));
    }

    /// <summary>The log. Unlike most of Unity it may be called on any thread.</summary>
    public class Debug
    {
        private static int errors;
        // As the editor's Console folds them: how often each exception came.
        private static readonly ConcurrentDictionary<string, int> Thrown = new ConcurrentDictionary<string, int>();
        internal static int Errors => errors;
        /// <summary>The time of a message; in Unity it is 0.1 ms in a build, and a multiple in the editor.</summary>
        internal static TimeSpan Cost { get; set; }
        public static void Log(object message) => Write(Console.Out, message, LogType.Log);
        public static void Log(object message, Object context) => Log(message);
        public static void LogFormat(string format, params object[] args) => Log(Formatted(format, args));
        public static void LogWarning(object message) => Write(Console.Error, message, LogType.Warning);
        public static void LogWarning(object message, Object context) => LogWarning(message);
        public static void LogWarningFormat(string format, params object[] args) => LogWarning(Formatted(format, args));
        public static void LogError(object message) => Fail(message, LogType.Error);
        public static void LogError(object message, Object context) => LogError(message);
        public static void LogErrorFormat(string format, params object[] args) => LogError(Formatted(format, args));
        public static void LogException(Exception exception) => LogException(exception, null);

        public static void LogException(Exception exception, Object context)
        {
            var text = Inspector.Explained(exception, context);
            if (Thrown.AddOrUpdate(text, 1, (again, times) => times + 1) == 1) Fail(text, LogType.Exception);
            else
            {
                Interlocked.Increment(ref errors);
                Application.SayLogged(text, LogType.Exception);
            }
        }

        /// <summary>The end of a Play: what came more than once.</summary>
        internal static void SayRepeated()
        {
            foreach (var one in Thrown.Where(one => one.Value > 1))
            {
                var begin = one.Key.Split('\n').Take(2).Select(line => line.Trim());
                Console.Error.WriteLine($"{one.Value - 1} times more: {string.Join(" ", begin)}");
            }
            Thrown.Clear();
        }

        public static void Assert(bool condition) => Assert(condition, "Assertion failed");

        public static void Assert(bool condition, string message)
        {
            if (!condition) Fail(message, LogType.Assert);
        }

        // Nobody sees a line here.
        public static void DrawLine(Vector3 start, Vector3 end) { }
        public static void DrawLine(Vector3 start, Vector3 end, Color color) { }
        public static void DrawRay(Vector3 start, Vector3 dir) { }
        public static void DrawRay(Vector3 start, Vector3 dir, Color color) { }
        private static string Formatted(string format, object[] args) =>
            string.Format(System.Globalization.CultureInfo.InvariantCulture, format, args);

        private static void Fail(object message, LogType type)
        {
            Interlocked.Increment(ref errors);
            Write(Console.Error, message, type);
        }

        private static void Write(System.IO.TextWriter where, object message, LogType type)
        {
            var text = Text(message);
            where.WriteLine(text);
            // A sleep would be longer than asked for.
            var end = System.Diagnostics.Stopwatch.GetTimestamp()
                + (Cost.TotalSeconds * System.Diagnostics.Stopwatch.Frequency);
            while (System.Diagnostics.Stopwatch.GetTimestamp() < end) { }
            Application.SayLogged(text, type);
        }

        private static string Text(object message) =>
            message is IFormattable number
                ? number.ToString(null, System.Globalization.CultureInfo.InvariantCulture)
                : message?.ToString() ?? "Null";
    }
}
