// Lesson 02 in a terminal: the terminal client of LazyPirateClient.cs, with the same LazyPirateRequester.
//
//     dotnet run --project csharp-console -- 2
//     dotnet run --project csharp-console -- 2 --text balance     only asks
using System;

namespace NetMQExample.Terminal
{
    internal static class Lesson02
    {
        public static void Run(Arguments arguments)
        {
            var endpoint = arguments.Text("endpoint", "tcp://127.0.0.1:5552");
            var count = arguments.Whole("count", 10);
            var text = arguments.Text("text", "add 1");
            var timeout = arguments.Seconds("timeout", 0.5);
            var tries = arguments.Whole("tries", 5);
            arguments.RefuseTheRest();

            using var pirate = new LazyPirateRequester(endpoint, timeout, tries, Console.WriteLine);
            Console.WriteLine($"asking {endpoint}");
            for (var i = 1; i <= count; i++)
            {
                var reply = LogText.Printable(pirate.Request(text));
                Console.WriteLine($"{i}: sent {text}, received {reply}");
            }
            Console.WriteLine($"done: {count} replies");
        }
    }
}
