// A game whose agents see and do texts, dictionaries and sequences: class Post of test_10_many_agents.py, in C#.
//
//     dotnet checks.dll game --endpoint tcp://127.0.0.1:5560
using System;
using System.Collections.Generic;
using System.Linq;

namespace NetMQExample.Tests
{
    internal sealed class Post : IAgentSimulation
    {
        private string written;
        private List<object> stamps;
        private int steps;

        public string Name => "Post";

        public double Dt => 0.5;

        public IReadOnlyList<(string Name, GymSpace Observation, GymSpace Action)> Agents { get; } = new[]
        {
            ("ann", GymSpace.Dict(("says", GymSpace.Text(20, 0)), ("stamps", GymSpace.Sequence(GymSpace.Box(0, 9, 2)))),
                GymSpace.Dict(("says", GymSpace.Text(5, 0)), ("times", GymSpace.Discrete(4)))),
            ("bob", GymSpace.Text(20, 0), GymSpace.Sequence(GymSpace.Discrete(5))),
        };

        public InfoQueue Infos { get; } = new InfoQueue();

        public static void Run(string endpoint)
        {
            using var client = new EnvironmentClient(endpoint, TimeSpan.FromSeconds(20), Console.WriteLine);
            client.Run(new AgentSimulator(new Post()), 0, answer => answer());
        }

        public void ResetWorld(RandomGenerator random, IReadOnlyDictionary<string, object> options) =>
            (written, stamps, steps) = ((string)options.GetValueOrDefault("says") ?? "", new List<object>(), 0);

        public void Apply(IReadOnlyDictionary<string, SpaceReader> actions)
        {
            steps++;
            stamps = ((List<object>)actions["bob"].Value).ToList();
            if (!actions.TryGetValue("ann", out var letter)) return;
            var parts = (Dictionary<string, object>)letter.Value;
            written = string.Concat(Enumerable.Repeat((string)parts["says"], (int)(long)parts["times"]));
            Infos.Send("bob", new Dictionary<string, object> { ["stamps"] = stamps, ["letter"] = parts });
        }

        public void Observe(string agent, SpaceWriter seen)
        {
            if (agent == "bob") seen.Set(written);
            else
                seen.Set(new Dictionary<string, object>
                {
                    ["stamps"] = stamps.Select(stamp => (object)new[] { (long)stamp, 0.5 * (long)stamp }).ToList(),
                    ["says"] = written,
                });
        }

        public (double Reward, bool Terminated, bool Truncated) RewardAndEnd(
            string agent, IDictionary<string, object> info)
        {
            info["read"] = new List<object> { written, (long)stamps.Count };
            return (stamps.Count, agent == "ann" && steps == 4, agent == "bob" && steps == 6);
        }

        public void OnInfo(string agent, IReadOnlyDictionary<string, object> info) => Infos.Send(agent, info);

        public MessageArray Render() => throw new MessageException("no-picture", "there is none");
    }
}
