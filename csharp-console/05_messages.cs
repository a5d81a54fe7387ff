// Lesson 05 in a terminal: the terminal client of MessagesClient.cs, with the same MessageRequester.
//
//     dotnet run --project csharp-console -- 5
using System;

namespace NetMQExample.Terminal
{
    internal static class Lesson05
    {
        public static void Run(Arguments arguments)
        {
            var endpoint = arguments.Text("endpoint", "tcp://127.0.0.1:5555");
            var count = arguments.Whole("count", 10);
            var timeout = arguments.Seconds("timeout", 2.5);
            arguments.RefuseTheRest();

            using var requester = new MessageRequester(endpoint);
            Console.WriteLine($"asking {endpoint}");
            for (var i = 1; i <= count; i++)
                Console.WriteLine(TestPicture.Line(i, requester.Request(TestPicture.Request(i), timeout)));
            Console.WriteLine($"done: {count} replies");
        }
    }
}
