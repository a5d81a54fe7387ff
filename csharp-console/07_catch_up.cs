// Lesson 07 in a terminal: the terminal client of CatchUpFollower.cs, with the same PoseSubscriber.
//
//     dotnet run --project csharp-console -- 7                    follow 300 poses, and notice each one missed
//     dotnet run --project csharp-console -- 7 --work 0.001       a slow one: give the server --interval 0
//     dotnet run --project csharp-console -- 7 --until 1000       end at the pose of this number
using System;
using System.Diagnostics;
using System.Threading;

namespace NetMQExample.Terminal
{
    internal static class Lesson07
    {
        public static void Run(Arguments arguments)
        {
            var endpoint = arguments.Text("endpoint", "tcp://127.0.0.1:5557");
            var snapshots = arguments.Text("snapshots", "");
            var count = arguments.Whole("count", 300);
            var until = arguments.Whole("until", 0);
            var seconds = arguments.Seconds("seconds", 60);
            var every = arguments.Whole("every", 60);
            var timeout = arguments.Seconds("timeout", 5);
            var work = arguments.Seconds("work", 0);
            arguments.RefuseTheRest();

            var time = Stopwatch.StartNew();
            using var subscriber = new PoseSubscriber(endpoint, snapshots, Console.WriteLine);
            var pose = subscriber.Pose;
            while (subscriber.Received < count && time.Elapsed < seconds)
            {
                var news = subscriber.Receive(timeout);
                pose = subscriber.Pose;
                var p = pose.Position;
                if (news && every > 0 && subscriber.Received % every == 0)
                    Console.WriteLine(FormattableString.Invariant($"{pose.Number}: at {p.X:F4} {p.Y:F4} {p.Z:F4}"));
                if (until > 0 && pose.Number >= until) break;
                Thread.Sleep(work);
            }
            Console.WriteLine($"done: received {subscriber.Received}, missed {subscriber.Missed}; "
                + $"run {pose.Run} at {pose.Number}, checksum {subscriber.Checksum}");
        }
    }
}
