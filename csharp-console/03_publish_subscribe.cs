// Lesson 03 in a terminal: the console twin of PoseFollower.cs, with the same PoseSubscriber.
//
//     dotnet run --project csharp-console -- 3                         follow 300 poses, and know of each one missed
//     dotnet run --project csharp-console -- 3 --newest --work 0.1     only the newest pose: drain what waits
//     dotnet run --project csharp-console -- 3 --listen news           a topic is a prefix: newsflash/ comes as well
//     dotnet run --project csharp-console -- 3 --listen news/          the delimiter at its end cures that
using System;
using System.Diagnostics;
using System.Threading;

namespace NetMQExample.Terminal
{
    internal static class Lesson03
    {
        public static void Run(Arguments arguments)
        {
            var (endpoint, snapshots) = (arguments.Text("endpoint", "tcp://127.0.0.1:5553"), arguments.Text("snapshots", ""));
            var (count, until) = (arguments.Whole("count", 300), arguments.Whole("until", 0));
            var (seconds, patience) = (arguments.Seconds("seconds", 60), arguments.Seconds("patience", 5));
            var (every, hwm) = (arguments.Whole("every", 60), arguments.Whole("hwm", 1000));
            var (work, newest) = (arguments.Seconds("work", 0), arguments.Flag("newest"));
            // A word that no topic begins with stands for: do not listen, follow.
            var prefix = arguments.Text("listen", "(nothing)");
            arguments.RefuseTheRest();
            if (prefix != "(nothing)") Listen(endpoint, prefix, count, patience);
            else
            {
                using var subscriber = new PoseSubscriber(endpoint, snapshots, Console.WriteLine, hwm);
                var time = Stopwatch.StartNew();
                while (subscriber.Received < count && time.Elapsed < seconds)
                {
                    var news = newest ? subscriber.ReceiveNewest(patience) : subscriber.Receive(patience);
                    if (news && every > 0 && subscriber.Received % every == 0) Console.WriteLine(subscriber.Pose);
                    if (until > 0 && subscriber.Pose.Number >= until) break;
                    Thread.Sleep(work);
                }
                Console.WriteLine(subscriber.Summary());
            }
        }

        private static void Listen(string endpoint, string prefix, int count, TimeSpan patience)
        {
            using var listener = new TopicListener(endpoint, prefix);
            Console.WriteLine($"listening to '{prefix}' from {endpoint}");
            for (var i = 0; i < count; i++) Console.WriteLine($"received {NetMQLifetime.Printable(listener.Receive(patience))}");
            Console.WriteLine($"done: received {count}");
        }
    }
}
