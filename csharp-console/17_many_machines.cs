// Lesson 17 in a terminal: the terminal client of FleetMember.cs, with the same FleetSimulator.
//
//     dotnet run --project csharp-console -- 17                        a simulator, until the hub sends it home
//     dotnet run --project csharp-console -- 17 --endpoint beacon://hub:5567        the hub with --beacon hub
//     dotnet run --project csharp-console -- 17 --keys keys            with lesson 15's keys
//     dotnet run --project csharp-console -- 17 --crash-after 200      trouble: it ends in the middle of an episode
//     dotnet run --project csharp-console -- 17 --delay 8              trouble: so many seconds for each step
using System;

namespace NetMQExample.Terminal
{
    internal static class Lesson17
    {
        public static void Run(Arguments arguments)
        {
            var endpoint = arguments.Text("endpoint", "tcp://127.0.0.1:5567");
            var folder = arguments.Text("keys", "");
            var count = arguments.Whole("count", 0);
            var timeout = arguments.Seconds("timeout", 30);
            var crashAfter = arguments.Whole("crash-after", 0);
            var delay = arguments.Seconds("delay", 0);
            var build = arguments.Text("build", "1");
            arguments.RefuseTheRest();

            if (folder != "") NetMQConnection.Prepare = new ClientKeys(folder).Apply;
            var world = new SceneSimulator("CartPole", 0.02, new[] { new CartPole() });
            var simulator = new FleetSimulator(world, build) { CrashAfter = crashAfter, Delay = delay };
            simulator.Crash = line =>
            {
                Console.WriteLine(line);
                Environment.Exit(1);
            };
            using var client = new EnvironmentClient(endpoint, timeout, Console.WriteLine);
            Console.WriteLine($"asking {endpoint}");
            client.Run(simulator, count, answer => answer());
            Console.WriteLine($"done: {simulator.Episodes} episodes, {simulator.Steps} steps");
        }
    }
}
