// The running game as a whole: its switches, its clock and its log.
using System;
using System.Threading;

namespace UnityEngine
{
    public class Application
    {
        private static bool background;

        public static event Action quitting;

        internal static bool QuitAsked { get; set; }

        internal static bool Playing { get; set; }

        public static bool isEditor => false;

        public static bool isPlaying
        {
            get { MainThread.Only("get_isPlaying"); return Playing; }
        }

        public static bool runInBackground
        {
            get { MainThread.Only("get_runInBackground"); return background; }
            set { MainThread.Only("set_runInBackground"); background = value; }
        }

        public static void Quit()
        {
            MainThread.Only(nameof(Quit));
            QuitAsked = true;
        }

        internal static void SayQuitting() => quitting?.Invoke();
    }

    public class Time
    {
        internal static double Now { get; set; }

        internal static double Elapsed { get; set; }

        internal static int Frames { get; set; }

        internal static Func<double> Clock { get; set; } = () => 0;

        public static float time => (float)Checked("get_time", Now);

        public static float deltaTime => (float)Checked("get_deltaTime", Elapsed);

        public static float fixedDeltaTime => (float)Checked("get_fixedDeltaTime", 0.02);

        public static float realtimeSinceStartup => (float)Checked("get_realtimeSinceStartup", Clock());

        public static int frameCount => (int)Checked("get_frameCount", Frames);

        private static double Checked(string api, double value)
        {
            MainThread.Only(api);
            return value;
        }
    }

    /// <summary>The log. Unlike most of Unity it may be called on any thread.</summary>
    public class Debug
    {
        private static int errors;

        internal static int Errors => errors;

        public static void Log(object message) => Console.WriteLine(Text(message));

        public static void Log(object message, Object context) => Log(message);

        public static void LogWarning(object message) => Console.Error.WriteLine(Text(message));

        public static void LogWarning(object message, Object context) => LogWarning(message);

        public static void LogError(object message)
        {
            Interlocked.Increment(ref errors);
            Console.Error.WriteLine(Text(message));
        }

        public static void LogError(object message, Object context) => LogError(message);

        public static void LogException(Exception exception) => LogError(exception);

        public static void LogException(Exception exception, Object context) => LogError(exception);

        private static string Text(object message) =>
            message is IFormattable number ? number.ToString(null, System.Globalization.CultureInfo.InvariantCulture) : message?.ToString() ?? "Null";
    }
}
