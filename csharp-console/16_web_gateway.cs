// Lesson 16 in a terminal: the terminal client of HelloWeb.cs, with the same requesters.
//
//     dotnet run --project csharp-console -- 16
//     dotnet run --project csharp-console -- 16 --socketio       the same by Socket.IO
using System;
using System.Threading;

namespace NetMQExample.Terminal
{
    internal static class Lesson16
    {
        public static void Run(Arguments arguments)
        {
            var endpoint = arguments.Text("endpoint", "http://127.0.0.1:5566");
            var count = arguments.Whole("count", 10);
            var text = arguments.Text("text", "Hello");
            var socketIO = arguments.Flag("socketio");
            var token = arguments.Text("token", "");
            var timeout = arguments.Seconds("timeout", 2.5);
            arguments.RefuseTheRest();

            using var requester = WebRequester.To(endpoint, "hello", socketIO, token, timeout);
            Console.WriteLine($"asking {endpoint}");
            for (var i = 1; i <= count; i++)
            {
                requester.Ask(text);
                string[] frames;
                // A game looks once a frame.
                while (!requester.TryReceive(out frames)) Thread.Sleep(1);
                Console.WriteLine($"{i}: sent {text}, received {WebText.Printable(string.Join(" ", frames))}");
            }
            Console.WriteLine($"done: {count} replies");
        }
    }
}
