// Lesson 12 in a terminal: the terminal client of FilmedDrive.cs, with the same ViewSender, and cameras that draw.
//
//     dotnet run --project csharp-console -- 12                 a car drives six seconds or more, and may be filmed
//     dotnet run --project csharp-console -- 12 --count 3000    for a minute
using System;
using System.Diagnostics;
using System.Threading;
using System.Threading.Tasks;

namespace NetMQExample.Terminal
{
    internal static class Lesson12
    {
        public static void Run(Arguments arguments)
        {
            var endpoint = arguments.Text("endpoint", "tcp://127.0.0.1:5562");
            var count = arguments.Whole("count", 300);
            var timeout = arguments.Seconds("timeout", 30);
            arguments.RefuseTheRest();

            NetMQConnection.Check(endpoint);
            Console.WriteLine($"asking {endpoint}");
            var drive = new SelfDriving();
            var front = new FilmView("front", 320, 240);
            var map = new FilmView("map", 320, 240);
            using var over = new CancellationTokenSource();
            ViewSender? sender = null;
            var network = Task.Run(() =>
            {
                using (sender = new ViewSender(endpoint, timeout, Console.WriteLine))
                    sender.Run(new[] { front, map }, over.Token);
            });
            while (sender?.Connected != true && !network.IsCompleted) Thread.Sleep(10);
            bool GoesOn() => count == 0 || drive.Steps < count || front.Filming || map.Filming;
            for (var clock = Stopwatch.StartNew(); !network.IsCompleted && GoesOn();)
            {
                drive.Step();
                if (front.Due() is Picture seen) { drive.DrawFront(seen); front.Take(seen); }
                if (map.Due() is Picture above) { drive.DrawMap(above); map.Take(above); }
                while (clock.Elapsed.TotalSeconds < drive.Steps * Drive.StepSeconds) Thread.Sleep(1);
            }
            over.Cancel();
            network.GetAwaiter().GetResult();
            Console.WriteLine($"done: {drive.Steps} steps");
        }
    }
}
