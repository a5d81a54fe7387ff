// Lesson 03 in a terminal: the terminal client of PoseFollower.cs, with the same TopicListener.
//
//     dotnet run --project csharp-console -- 3                              300 poses, one in 60 is printed
//     dotnet run --project csharp-console -- 3 --work 0.1 --newest          only the newest: drain what waits
//     dotnet run --project csharp-console -- 3 --topic news --every 1       a topic is a prefix: also newsflash/
//     dotnet run --project csharp-console -- 3 --topic news/ --every 1      the delimiter at its end cures that
using System;
using System.Threading;

namespace NetMQExample.Terminal
{
    internal static class Lesson03
    {
        public static void Run(Arguments arguments)
        {
            var endpoint = arguments.Text("endpoint", "tcp://127.0.0.1:5553");
            var topic = arguments.Text("topic", "pose/");
            var count = arguments.Whole("count", 300);
            var every = arguments.Whole("every", 60);
            var timeout = arguments.Seconds("timeout", 5);
            var work = arguments.Seconds("work", 0);
            var hwm = arguments.Whole("hwm", 1000);
            var newest = arguments.Flag("newest");
            arguments.RefuseTheRest();

            using var listener = new TopicListener(endpoint, topic, hwm);
            Console.WriteLine($"listening to '{topic}' from {endpoint}");
            for (var i = 0; i < count; i++)
            {
                var message = newest ? listener.Newest(timeout) : listener.Receive(timeout);
                if (every > 0 && i % every == 0) Console.WriteLine($"received {LogText.Printable(message)}");
                Thread.Sleep(work);
            }
            Console.WriteLine($"done: received {count}");
        }
    }
}
