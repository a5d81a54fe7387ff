// Lesson 10 in a terminal: the terminal client of PursuitGame.cs, with the same Pursuit.
//
//     dotnet run --project csharp-console -- 10                                hunters and rabbits, until it is closed
//     dotnet run --project csharp-console -- 10 --world CartPole --areas 16    sixteen poles on sixteen carts
//     dotnet run --project csharp-console -- 10 --world Car --areas 16         sixteen of lesson 08's cars
//     dotnet run --project csharp-console -- 10 --count 3                      leave after so many games or episodes
using System;
using System.Linq;

namespace NetMQExample.Terminal
{
    internal static class Lesson10
    {
        public static void Run(Arguments arguments)
        {
            var endpoint = arguments.Text("endpoint", "tcp://127.0.0.1:5559");
            var world = arguments.Text("world", "Pursuit");
            var areas = arguments.Whole("areas", 16);
            var count = arguments.Whole("count", 0);
            var timeout = arguments.Seconds("timeout", 30);
            arguments.RefuseTheRest();

            if (areas < 1 || areas > 1024) throw new UsageException($"--areas takes 1 to 1024, not {areas}");
            var game = new Pursuit();
            var copies = Enumerable.Range(0, areas);
            var simulator = world switch
            {
                "CartPole" => new SceneSimulator(world, 0.02, copies.Select(_ => new CartPole()).ToArray()),
                "Car" => new SceneSimulator(
                    world, Drive.StepSeconds, copies.Select(_ => new RoadCar(false)).ToArray()),
                "Pursuit" => new SceneSimulator(world, 0.1, game.Players, game),
                _ => throw new UsageException($"--world takes CartPole, Car or Pursuit, not '{world}'"),
            };
            game.SendInfo = simulator.SendInfo;
            using var client = new EnvironmentClient(endpoint, timeout, Console.WriteLine);
            Console.WriteLine($"asking {endpoint}");
            // In a game an episode of each of its players begins.
            client.Run(simulator, world == "Pursuit" ? count * game.Players.Count : count, answer => answer());
            Console.WriteLine($"done: {simulator.Episodes} episodes, {simulator.Steps} steps");
        }
    }
}
