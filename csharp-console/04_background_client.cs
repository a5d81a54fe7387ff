// Lesson 04 in a terminal: the terminal client of HelloBackground.cs, with the same BackgroundClient.
//
//     dotnet run --project csharp-console -- 4
//     dotnet run --project csharp-console -- 4 --naive              lets each frame wait, to see the frames stop
using System;
using System.Diagnostics;
using System.Threading;

namespace NetMQExample.Terminal
{
    internal static class Lesson04
    {
        public static void Run(Arguments arguments)
        {
            var endpoint = arguments.Text("endpoint", "tcp://127.0.0.1:5554");
            var count = arguments.Whole("count", 10);
            var text = arguments.Text("text", "hello");
            var timeout = arguments.Seconds("timeout", 1);
            var tries = arguments.Whole("tries", 20);
            var naive = arguments.Flag("naive");
            arguments.RefuseTheRest();

            Console.WriteLine($"asking {endpoint}");
            // An unknown host would be the error of each request. A terminal has the time to look first.
            NetMQConnection.Check(endpoint);
            using var client = new BackgroundClient(endpoint, timeout, tries);

            // This is a game, frame after frame. Each frame runs what came back, and asks once.
            int asked = 0, replies = 0, frames = 0;
            var longest = 0L;
            var shown = "";
            string? why = null;
            void OnReply(string reply) =>
                Console.WriteLine($"{++replies}: sent {text}, received {LogText.Printable(reply)}");
            for (var frame = Stopwatch.StartNew(); replies < count && why == null; frames++, frame.Restart())
            {
                var (state, error) = client.Status;
                if (error != shown && state != ClientState.Lost)
                {
                    Console.WriteLine($"trouble: {error}");
                    shown = error;
                }
                client.Poll();
                if (asked < count && client.Request(text, OnReply, reason => why ??= reason)) asked++;
                while (naive && replies < asked && why == null) client.Poll();
                Thread.Sleep(TimeSpan.FromSeconds(1 / 60.0));
                longest = Math.Max(longest, frame.ElapsedMilliseconds);
            }
            Console.WriteLine($"frames: {frames}, the longest took {longest} ms");
            if (why != null) throw new GaveUpException(why);
            Console.WriteLine($"done: {replies} replies");
        }
    }
}
