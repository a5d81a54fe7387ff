// Lesson 05 in a terminal: the terminal client of MessagesClient.cs, with the plain MessageRequester.
//
//     dotnet run --project csharp-console -- 5
//     dotnet run --project csharp-console -- 5 --fps 60     a camera with 60 pictures a second: the newest wins
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
            var camera = new TestCamera(arguments.Whole("fps", 0));
            arguments.RefuseTheRest();

            using var requester = new MessageRequester(endpoint);
            Console.WriteLine($"asking {endpoint}");
            var pixels = new byte[TestCamera.Size];
            try
            {
                for (var i = 1; i <= count; i++)
                {
                    while (!camera.Look()) Thread.Sleep(1);
                    TestCamera.Draw(pixels, camera.Number);
                    var request = TestCamera.Frame(camera.Number, pixels);
                    Console.WriteLine(TestCamera.Describe(i, request, requester.Request(request, patience)));
                }
            }
            catch (MessageException e)
            {
                // What ends a twin with "gave up" and exit code 1.
                throw new TimeoutException(e.Message, e);
            }
            Console.WriteLine($"done: {count} replies, {camera.Number - count} pictures skipped");
        }
    }
}
