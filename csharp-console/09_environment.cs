// Lesson 09 in a terminal: the terminal client of CartPoleAgent.cs, with the same CartPole.
//
//     dotnet run --project csharp-console -- 9                  a pole on a cart, until the environment closes it
//     dotnet run --project csharp-console -- 9 --world Car      lesson 08's car; with --picture it sees the road
//     dotnet run --project csharp-console -- 9 --count 3        leave after so many episodes
using System;

namespace NetMQExample.Terminal
{
    internal static class Lesson09
    {
        public static void Run(Arguments arguments)
        {
            var endpoint = arguments.Text("endpoint", "tcp://127.0.0.1:5559");
            var world = arguments.Text("world", "CartPole");
            var count = arguments.Whole("count", 0);
            var timeout = arguments.Seconds("timeout", 30);
            var picture = arguments.Flag("picture");
            arguments.RefuseTheRest();

            var simulator = world switch
            {
                "CartPole" => new SceneSimulator(world, 0.02, new[] { new CartPole() }),
                "Car" => new SceneSimulator(world, Drive.StepSeconds, new[] { new RoadCar(picture) }),
                _ => throw new UsageException($"--world takes CartPole or Car, not '{world}'"),
            };
            using var client = new EnvironmentClient(endpoint, timeout, Console.WriteLine);
            Console.WriteLine($"asking {endpoint}");
            client.Run(simulator, count, answer => answer());
            Console.WriteLine($"done: {simulator.Episodes} episodes, {simulator.Steps} steps");
        }
    }
}
