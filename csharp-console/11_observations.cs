// Lesson 11 in a terminal: the client of GymManager.cs, with a car that needs no engine; and what a locator means.
//
//     dotnet run --project csharp-console -- 11                                a car collects coins, until it is closed
//     dotnet run --project csharp-console -- 11 --agents 3                     so many: agent_0, agent_1, agent_2
//     dotnet run --project csharp-console -- 11 --count 3                      leave after so many episodes
//     dotnet run --project csharp-console -- 11 --locator car@.speed           prints: 'car'@['speed'] = $
//     dotnet run --project csharp-console -- 11 --locator .speed --scope car@.body
//     dotnet run --project csharp-console -- 11 --locator=-speed               says at which column it is wrong
using System;
using System.Linq;

namespace NetMQExample.Terminal
{
    internal static class Lesson11
    {
        public static void Run(Arguments arguments)
        {
            if (arguments.Has("locator"))
            {
                PrintLocator(arguments);
                return;
            }
            var endpoint = arguments.Text("endpoint", "tcp://127.0.0.1:5559");
            var count = arguments.Whole("count", 0);
            var agents = arguments.Whole("agents", 1);
            var timeout = arguments.Seconds("timeout", 30);
            arguments.RefuseTheRest();
            if (agents < 1 || agents > 1024) throw new UsageException($"--agents takes 1 to 1024, not {agents}");

            var cars = Enumerable.Range(0, agents).Select(_ => new DrawnCoinCar()).ToArray();
            var simulator = new SceneSimulator("Coins", 0.1, cars);
            using var client = new EnvironmentClient(endpoint, timeout, Console.WriteLine);
            Console.WriteLine($"asking {endpoint}");
            client.Run(simulator, count, answer => answer());
            Console.WriteLine($"done: {simulator.Episodes} episodes, {simulator.Steps} steps");
        }

        private static void PrintLocator(Arguments arguments)
        {
            var text = arguments.Text("locator", "");
            var given = arguments.Has("scope");
            var scope = arguments.Text("scope", "");
            var name = arguments.Text("name", "");
            arguments.RefuseTheRest();
            Locator? outer = null;
            try { if (given) outer = Locator.Parse(scope); }
            catch (LocatorException e) { throw new UsageException($"scope, {e.Message}"); }
            Console.WriteLine(Locator.Parse(text, name, outer));
        }
    }
}
