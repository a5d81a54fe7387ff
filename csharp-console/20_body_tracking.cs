// Application 20 in a terminal: the terminal client of BodyTracker.cs, with the same BodyListener.
//
//     dotnet run --project csharp-console -- 20                 150 poses of person 0, one in 25 is printed
//     dotnet run --project csharp-console -- 20 --person 1      the other one
//     dotnet run --project csharp-console -- 20 --hand left     a hand, of a server with --camera and --hands
//     dotnet run --project csharp-console -- 20 --work 0.1      too slow: it skips poses and is never late
using System;
using System.Threading;

namespace NetMQExample.Terminal
{
    internal static class Lesson20
    {
        public static void Run(Arguments arguments)
        {
            var endpoint = arguments.Text("endpoint", "tcp://127.0.0.1:5570");
            var person = arguments.Whole("person", 0);
            var hand = arguments.Text("hand", "");
            var count = arguments.Whole("count", 150);
            var every = arguments.Whole("every", 25);
            var timeout = arguments.Seconds("timeout", 5);
            var work = arguments.Seconds("work", 0);
            arguments.RefuseTheRest();

            using var listener = new BodyListener(endpoint, person, hand);
            Console.WriteLine($"listening to '{listener.Topic}' from {endpoint}");
            for (var i = 0; i < count || count == 0; i++)
            {
                var pose = listener.Receive(timeout);
                if (listener.Restarted) Console.WriteLine($"{listener.Name}: the server was started again");
                if (every > 0 && i % every == 0) Console.WriteLine(listener.Line(pose));
                Thread.Sleep(work);
            }
            Console.WriteLine($"done: {count} poses, {listener.Skipped} skipped");
        }
    }
}
