// Lesson 05 in a terminal: the console twin of MessagesClient.cs, with the same MessageRequester.
//
//     dotnet run --project csharp-console -- 5
//     dotnet run --project csharp-console -- 5 --fps 60         a camera with 60 pictures a second: the newest wins
//     dotnet run --project csharp-console -- 5 --wrong shape    a wrong message first: json, version, kind, shape, frames
//     dotnet run --project csharp-console -- 5 --measure        what pooled buffers are worth, see 05_measure.cs
// JPEG is for the Python client and for Unity: .NET itself has no encoder.
using System;
using System.Threading;

namespace NetMQExample.Terminal
{
    internal static class Lesson05
    {
        public static void Run(Arguments arguments)
        {
            var endpoint = arguments.Text("endpoint", "tcp://127.0.0.1:5555");
            var count = arguments.Whole("count", 10);
            var patience = arguments.Seconds("patience", 2.5);
            var fps = arguments.Whole("fps", 0);
            var wrong = arguments.Text("wrong", "");
            var measure = arguments.Flag("measure");
            var check = arguments.Flag("check");
            arguments.RefuseTheRest();
            WrongMessage.Check(wrong);
            try
            {
                if (check) MessageCheck.Run();
                else if (measure) MessageMeasure.Run(endpoint, patience);
                else Ask(endpoint, count, patience, fps, wrong);
            }
            catch (MessageException e)
            {
                // What ends a twin with "gave up" and exit code 1.
                throw new TimeoutException(e.Message, e);
            }
        }

        private static void Ask(string endpoint, int count, TimeSpan patience, int fps, string wrong)
        {
            Console.WriteLine($"asking {endpoint}");
            using var requester = new MessageRequester(endpoint);
            var pixels = new byte[TestCamera.Size];
            if (wrong != "") WrongMessage.ShowRefusal(requester, wrong, patience);
            var camera = new TestCamera(fps);
            for (var i = 1; i <= count; i++)
            {
                while (!camera.Look()) Thread.Sleep(1);
                TestCamera.Draw(pixels, camera.Number);
                var request = TestCamera.Frame(camera.Number, pixels);
                Console.WriteLine(TestCamera.Describe(i, request, requester.Request(request, patience)));
            }
            Console.WriteLine($"done: {count} replies, {camera.Number - count} pictures skipped");
        }
    }
}
