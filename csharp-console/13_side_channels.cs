// Lesson 13 in a terminal: the terminal client of SideChannelClient.cs, with the same SideChannelRounds.
//
//     dotnet run --project csharp-console -- 13                       draws parameters, and records statistics
//     dotnet run --project csharp-console -- 13 --trouble unknown     sends to a channel that the server has not
//     dotnet run --project csharp-console -- 13 --trouble cut         sends a message without its end
//     dotnet run --project csharp-console -- 13 --trouble throw       has a handler that throws
using System;
using NetMQExample.MLAgents;
using NetMQExample.MLAgents.SideChannels;

namespace NetMQExample.Terminal
{
    internal static class Lesson13
    {
        public static void Run(Arguments arguments)
        {
            var endpoint = arguments.Text("endpoint", "tcp://127.0.0.1:5563");
            var count = arguments.Whole("count", 5);
            var timeout = arguments.Seconds("timeout", 5);
            var trouble = arguments.Text("trouble", "none");
            arguments.RefuseTheRest();

            using var rounds = new SideChannelRounds(count, trouble, timeout * 2, Console.WriteLine);
            Academy.Instance.Begin((kind, values) =>
                Console.WriteLine(EngineConfigurationChannel.Describe(kind, values)));
            using var carrier = new SideChannelCarrier(endpoint, timeout);
            Console.WriteLine($"asking {endpoint}");
            var data = Array.Empty<byte>();
            while (!rounds.Done) data = rounds.Exchange(carrier.Exchange(data, NetMQConnection.Slice));
            Console.WriteLine($"done: {count} rounds");
        }
    }
}
