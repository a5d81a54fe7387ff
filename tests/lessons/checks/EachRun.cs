// One run of a terminal client after the other in one process: `dotnet checks.dll each csharp-console.dll`. It reads one run a
// line, its words with tabs between, and prints what each has printed, and then `ended CODE`.
//
// For what ends before it talks to anybody: it would take as long to start .NET as all these runs take together.
using System;
using System.IO;
using System.Reflection;

namespace NetMQExample.Tests
{
    internal static class EachRun
    {
        public static void Run(string program)
        {
            var main = Assembly.LoadFrom(Path.GetFullPath(program)).EntryPoint;
            // The client sets Console's encoding, which makes its streams anew.
            var output = TextWriter.Synchronized(new StreamWriter(Console.OpenStandardOutput()) { AutoFlush = true });
            for (var line = Console.ReadLine(); line != null; line = Console.ReadLine())
            {
                using var said = new StringWriter();
                var both = TextWriter.Synchronized(said);
                Console.SetOut(both);
                Console.SetError(both);
                object code;
                try
                {
                    code = main.Invoke(null, new object[] { line.Split('\t') });
                }
                catch (TargetInvocationException e)
                {
                    both.WriteLine($"Unhandled exception. {e.InnerException}");
                    code = 134;
                }
                output.WriteLine($"{said.ToString().Trim()}\nended {code}");
            }
        }
    }
}
