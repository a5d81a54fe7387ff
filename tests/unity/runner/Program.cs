// Runs the package's tests in the player, each in a Play of its own: `dotnet runner.dll`, `mono runner.dll`.
//
// Prints a line for each, "passed NAME" or "FAILED NAME: why", among what the scripts log. A test's coroutine goes on
// once in each frame, and one that it returns is done first, as in Unity.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using System.Threading;
using NUnit.Framework;
using NUnit.Framework.Internal;
using UnityEngine.TestTools;
using UnityPlayer;

namespace NetMQExample.UnityTests
{
    internal static class Program
    {
        private const BindingFlags Any = BindingFlags.Static | BindingFlags.Public | BindingFlags.NonPublic;

        private static int Main()
        {
            var methods = typeof(Program).Assembly.GetTypes().SelectMany(type => type.GetMethods())
                .Where(one => one.IsDefined(typeof(UnityTestAttribute)) || one.IsDefined(typeof(TestAttribute)));
            var failed = 0;
            foreach (var method in methods)
                foreach (var words in Arguments(method))
                {
                    var name = $"{method.DeclaringType.Name}.{method.Name}({string.Join(",", words)})";
                    var why = Run(method, words);
                    Console.WriteLine(why == null ? $"passed {name}" : $"FAILED {name}: {why.Replace("\n", " ")}");
                    failed += why == null ? 0 : 1;
                }
            return failed == 0 ? 0 : 1;
        }

        private static IEnumerable<object[]> Arguments(MethodInfo method)
        {
            if (method.GetParameters().Length == 0) return new[] { new object[0] };
            var source = method.GetParameters().Single().GetCustomAttribute<ValueSourceAttribute>();
            var values = (IEnumerable)method.DeclaringType.GetField(source.SourceName, Any).GetValue(null);
            return values.Cast<object>().Select(value => new[] { value });
        }

        private static string Run(MethodInfo method, object[] words)
        {
            // One test's assertions are not counted against the next.
            using var isolated = new TestExecutionContext.IsolatedContext();
            var player = new Player(typeof(NetMQLifetime).Assembly);
            player.Begin(() => { });
            LogAssert.Begin();
            try
            {
                var made = method.Invoke(Activator.CreateInstance(method.DeclaringType), words);
                for (var steps = made is IEnumerator test ? Steps(test) : null; steps?.MoveNext() == true;)
                {
                    player.Frame();
                    Thread.Sleep(2);
                }
                LogAssert.End();
                return null;
            }
            catch (TargetInvocationException e) { return e.InnerException.Message; }
            catch (Exception e) { return e.Message; }
            finally { player.Stop(); }
        }

        private static IEnumerator Steps(IEnumerator test)
        {
            try
            {
                while (test.MoveNext())
                    if (test.Current is IEnumerator inner)
                        for (var steps = Steps(inner); steps.MoveNext();) yield return null;
                    else yield return null;
            }
            finally { (test as IDisposable)?.Dispose(); }
        }
    }
}
