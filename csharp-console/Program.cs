// Runs the terminal client of a lesson: dotnet run --project csharp-console -- NN [options].
// With --with-keys DIR the client of any lesson has lesson 15's keys, for a server behind its gate.py.
// With --unity it plays the lesson's MonoBehaviours instead; see Play.cs.
//
// A terminal client is a static class LessonNN with a method Run. It is found by that name, so that adding a lesson is
// adding its file. Exit codes: 0 done, 1 gave up, 2 wrong usage.
using System;
using System.IO;
using System.Linq;
using System.Reflection;

namespace NetMQExample.Terminal
{
    internal static class Program
    {
        private static int Main(string[] words)
        {
            Console.OutputEncoding = new System.Text.UTF8Encoding(false);
            AppDomain.CurrentDomain.UnhandledException += (_, thrown) => EndIfNetMQs((Exception)thrown.ExceptionObject);
            // .NET hands what arrives at a socket to its thread pool, and NetMQ's callback there hands it on to NetMQ's
            // own thread at once: this leaves the detour out. Only for a program whose other sockets never block in a
            // callback.
            Environment.SetEnvironmentVariable("DOTNET_SYSTEM_NET_SOCKETS_INLINE_COMPLETIONS", "1");
            try
            {
                var keys = Array.IndexOf(words, "--with-keys");
                if (keys >= 0 && keys + 1 < words.Length)
                {
                    NetMQConnection.Prepare = new ClientKeys(words[keys + 1]).Apply;
                    words = words.Where((word, i) => i != keys && i != keys + 1).ToArray();
                }
                if (words.Contains("--unity"))
                    return Play.Run(words[0], new Arguments(Play.WithoutUnitysOwn(words).Skip(1)));
                var lesson = Lesson(words.FirstOrDefault());
                lesson(new Arguments(words.Skip(1)));
                return 0;
            }
            // A UsageException, or what a client refuses.
            catch (ArgumentException e)
            {
                Console.Error.WriteLine(e.Message);
                return 2;
            }
            // A wait was in vain, or something was refused or aborted: GaveUpException and MessageException.
            catch (Exception e) when (e is TimeoutException || e is IOException)
            {
                Console.Error.WriteLine($"gave up: {e.Message}");
                return 1;
            }
        }

        // On NetMQ's own thread nobody can catch what a few bytes of a server's throw there: SECURITY.md has more.
        private static void EndIfNetMQs(Exception error)
        {
            if (error.StackTrace?.Contains("NetMQ.Core.Utils.Proactor") != true) return;
            Console.Error.WriteLine(
                $"gave up: NetMQ cannot read what the server sent: {LogText.Printable(error.Message)}; "
                + "is it one of this kit?");
            Environment.Exit(1);
        }

        private static Action<Arguments> Lesson(string? number)
        {
            var lessons = Assembly.GetExecutingAssembly().GetTypes()
                .Where(type => type.Name.StartsWith("Lesson", StringComparison.Ordinal) && type.Name.Length == 8)
                .ToDictionary(type => type.Name[6..]);
            if (number != null && lessons.TryGetValue(number.Split('_')[0].PadLeft(2, '0'), out var lesson))
                return lesson.GetMethod("Run")!.CreateDelegate<Action<Arguments>>();
            throw new UsageException(
                $"which lesson? Give its number first, one of: {string.Join(" ", lessons.Keys.OrderBy(key => key))}");
        }
    }
}
