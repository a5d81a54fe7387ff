// A first, silent stand-in: the scripts compile against it. Playing them comes with the player.
using System;

namespace UnityEngine
{
    public class Object { }

    public class Component : Object { }

    public class Behaviour : Component { }

    public class MonoBehaviour : Behaviour { }

    [AttributeUsage(AttributeTargets.Field)]
    public sealed class SerializeField : Attribute { }

    [AttributeUsage(AttributeTargets.Field)]
    public sealed class TooltipAttribute : Attribute
    {
        public readonly string tooltip;

        public TooltipAttribute(string tooltip) => this.tooltip = tooltip;
    }

    public static class Application
    {
        public static bool runInBackground { get; set; }
    }

    public static class Debug
    {
        public static void Log(object message) => Console.WriteLine(message);

        public static void LogError(object message) => Console.Error.WriteLine(message);
    }
}
