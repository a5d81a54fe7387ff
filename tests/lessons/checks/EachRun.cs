// One run of a terminal client after the other in one process: `dotnet checks.dll each csharp-console.dll`. It reads
// one run a line, a JSON list of its words, and prints what each has printed, and then `ended CODE`.
// With --seen it also says how many messages the editor's window could have shown.
//
// For what ends by itself: it would take as long to start .NET as all these runs take together.
using System;
using System.IO;
using System.Linq;
using System.Reflection;
using System.Threading;
using Newtonsoft.Json;

namespace NetMQExample.Tests
{
    internal static class EachRun
    {
        private static int sent, received;

        public static void Run(string program)
        {
            NetMQConnection.Seen += (_, own, _) => Interlocked.Increment(ref own ? ref sent : ref received);
            var main = Assembly.LoadFrom(Path.GetFullPath(program)).EntryPoint;
            // The client sets Console's encoding, which makes its streams anew.
            var output = TextWriter.Synchronized(new StreamWriter(Console.OpenStandardOutput()) { AutoFlush = true });
            using var input = new StreamReader(Console.OpenStandardInput());
            for (var line = input.ReadLine(); line != null; line = input.ReadLine())
            {
                using var said = new StringWriter();
                var both = TextWriter.Synchronized(said);
                Console.SetOut(both);
                Console.SetError(both);
                // The --with-keys of a run before has set it.
                NetMQConnection.Prepare = null;
                var before = NetMQLifetime.Users;
                var words = JsonConvert.DeserializeObject<string[]>(line);
                (sent, received) = (0, 0);
                object code;
                try { code = main.Invoke(null, new object[] { words.Where(word => word != "--seen").ToArray() }); }
                catch (TargetInvocationException e)
                {
                    both.WriteLine($"Unhandled exception. {e.InnerException}");
                    code = 134;
                }
                // A thread may leave a moment later: Dispose waits for it no longer than Unity's Stop may take.
                var left = words.Contains("--unity") || SpinWait.SpinUntil(() => NetMQLifetime.Users <= before, 20_000);
                if (!left) both.WriteLine("Unhandled: it has not left NetMQ");
                if (words.Contains("--seen")) both.WriteLine($"shown: {sent} sent, {received} received");
                var text = said.ToString();
                output.WriteLine($"{text}{(text.Length == 0 || text.EndsWith("\n") ? "" : "\n")}ended {code}");
            }
        }
    }
}
