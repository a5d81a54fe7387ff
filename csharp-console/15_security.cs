// Lesson 15 in a terminal: the terminal client of SecureHello.cs, with the same SecureRequester and ClientKeys.
//
//     dotnet run --project csharp-console -- 15
//     dotnet run --project csharp-console -- 15 --stranger           with a key that nobody has enrolled
//     dotnet run --project csharp-console -- 15 --plain              without keys
//     dotnet run --project csharp-console -- 15 --server-key=KEY     for a server of another key, which is not this one
using System;

namespace NetMQExample.Terminal
{
    internal static class Lesson15
    {
        public static void Run(Arguments arguments)
        {
            var endpoint = arguments.Text("endpoint", "tcp://127.0.0.1:5565");
            var count = arguments.Whole("count", 10);
            var timeout = arguments.Seconds("timeout", 1);
            var tries = arguments.Whole("tries", 3);
            var folder = arguments.Text("keys", "keys");
            var serverKey = arguments.Text("server-key", "");
            var stranger = arguments.Flag("stranger");
            var plain = arguments.Flag("plain");
            arguments.RefuseTheRest();

            var keys = plain ? null : new ClientKeys(folder, serverKey);
            if (stranger) keys = keys?.Stranger();
            using var requester = new SecureRequester(endpoint, keys, timeout, tries, Console.WriteLine);
            Console.WriteLine($"asking {endpoint}");
            for (var i = 1; i <= count; i++)
            {
                var reply = LogText.Printable(requester.Request("Hello"));
                Console.WriteLine($"{i}: sent Hello, received {reply}");
            }
            Console.WriteLine($"done: {count} replies");
        }
    }
}
