// The part of Unity's Test Framework (com.unity.test-framework) that the package's tests use, with its signatures.
using System;
using System.Collections.Generic;
using System.Text.RegularExpressions;
using NUnit.Framework;

namespace UnityEngine.TestTools
{
    [AttributeUsage(AttributeTargets.Method)]
    public sealed class UnityTestAttribute : NUnitAttribute { }

    /// <summary>Expects lines of the log in this order; an error that nobody expects fails the test.</summary>
    public static class LogAssert
    {
        private static readonly List<(LogType Type, string Line)> Logged = new List<(LogType, string)>();
        private static readonly Queue<(LogType Type, Predicate<string> Is, string Words)> Expected =
            new Queue<(LogType, Predicate<string>, string)>();

        public static bool ignoreFailingMessages { get; set; }

        public static void Expect(LogType type, string message) =>
            Expected.Enqueue((type, line => line == message, message));

        public static void Expect(LogType type, Regex message) =>
            Expected.Enqueue((type, message.IsMatch, $"{message}"));

        internal static void Begin()
        {
            ignoreFailingMessages = false;
            Logged.Clear();
            Expected.Clear();
            Application.logMessageReceived -= Hear;
            Application.logMessageReceived += Hear;
        }

        private static void Hear(string line, string stack, LogType type) => Logged.Add((type, line));

        internal static void End()
        {
            foreach (var (type, line) in Logged)
            {
                if (Expected.Count > 0 && Expected.Peek().Type == type && Expected.Peek().Is(line)) Expected.Dequeue();
                else if (type != LogType.Log && type != LogType.Warning && !ignoreFailingMessages)
                    throw new AssertionException($"Unhandled log message: {line}");
            }
            if (Expected.Count > 0)
                throw new AssertionException($"Expected log did not appear: {Expected.Peek().Words}");
        }
    }
}
