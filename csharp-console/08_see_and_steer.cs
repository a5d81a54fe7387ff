// Lesson 08 in a terminal: the terminal client of CameraSender.cs, with the same drive, and a camera that draws.
//
//     dotnet run --project csharp-console -- 8
//     dotnet run --project csharp-console -- 8 --lockstep       the world waits for each action
//     dotnet run --project csharp-console -- 8 --drive          arrow keys or W A S D take over, Enter gives back
// JPEG is for the Python client and for Unity: .NET itself has no encoder.
using System;
using System.Diagnostics;
using System.Threading;
using System.Threading.Tasks;

namespace NetMQExample.Terminal
{
    internal static class Lesson08
    {
        public static void Run(Arguments arguments)
        {
            var endpoint = arguments.Text("endpoint", "tcp://127.0.0.1:5558");
            int count = arguments.Whole("count", 500), every = arguments.Whole("every", 50);
            var timeout = arguments.Seconds("timeout", 1);
            var tries = arguments.Whole("tries", 5);
            var cameras = arguments.Text("cameras", "center");
            var start = arguments.Whole("start", 0);
            bool lockstep = arguments.Flag("lockstep"), keys = arguments.Flag("drive");
            arguments.RefuseTheRest();

            var road = new Road();
            var pictures = DrawnCamera.Pictures(cameras);
            var car = new Car(road, start);
            var camera = new DrawnCamera(road);
            var drive = new Drive(car, Console.WriteLine) { Every = every, Lockstep = lockstep };
            var keyboard = keys ? new Keyboard() : null;
            using var driver = new DriverClient(endpoint, timeout, tries, Console.WriteLine);
            Console.WriteLine($"asking {endpoint}");
            var skipped = 0;
            var clock = Stopwatch.StartNew();
            for (Task<DriveAction?>? asked = null; drive.Actions < count;)
            {
                // A picture is sent when the last one was answered. Of those in between, only the newest is wanted.
                if (asked != null) skipped++;
                else camera.Take(pictures, drive, car);
                asked ??= Task.Run(() => driver.Ask(pictures.ToMessage()));
                if (!lockstep) drive.Step();
                keyboard?.Poll(drive);
                while (lockstep ? !asked.IsCompleted : clock.Elapsed < drive.Time) Thread.Sleep(1);
                if (!asked.IsCompleted) continue;
                drive.Apply(asked.GetAwaiter().GetResult());
                if (lockstep) drive.Step();
                asked = null;
            }
            Console.WriteLine($"done: {drive.Actions} actions, {skipped} pictures skipped");
        }
    }
}
