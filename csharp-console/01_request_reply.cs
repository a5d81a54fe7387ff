// Lesson 01 in a terminal: the terminal client of HelloClient.cs, with the same HelloRequester.
//
//     dotnet run --project csharp-console -- 1
//     dotnet run --project csharp-console -- 1 --send-twice     what strict alternation means
using System;
using NetMQ;

namespace NetMQExample.Terminal
{
    internal static class Lesson01
    {
        public static void Run(Arguments arguments)
        {
            var endpoint = arguments.Text("endpoint", "tcp://127.0.0.1:5551");
            var count = arguments.Whole("count", 10);
            var text = arguments.Text("text", "Hello");
            var timeout = arguments.Seconds("timeout", 2.5);
            var sendTwice = arguments.Flag("send-twice");
            arguments.RefuseTheRest();

            using var requester = new HelloRequester(endpoint);
            Console.WriteLine($"asking {endpoint}");
            if (sendTwice) ShowRefusal(requester, text, timeout);
            for (var i = 1; i <= count; i++)
            {
                var reply = requester.Request(text, timeout);
                Console.WriteLine($"{i}: sent {text}, received {LogText.Printable(reply)}");
            }
            Console.WriteLine($"done: {count} replies");
        }

        private static void ShowRefusal(HelloRequester requester, string text, TimeSpan timeout)
        {
            requester.Send(text, timeout);
            try { requester.Send(text, timeout); }
            catch (FiniteStateMachineException e) { Console.WriteLine($"refused: {e.GetType().Name}: {e.Message}"); }
            var reply = LogText.Printable(requester.Receive(timeout));
            Console.WriteLine($"received {reply}: now REQ may send again");
        }
    }
}
