// Lesson 10, the game: three hunters, two rabbits, and a meadow with a fence. In Python: pursuit.py.
//
// Rabbits are faster, so hunters must drive them into a corner. A hunter who runs tires, and one without energy is out;
// a rabbit that is caught is out as well. The game ends when all rabbits are caught, or no hunter is left.
// Both sides give the same numbers to the last bit: there is nothing but plus, minus, times, divide and square root.
// Your own game takes its place.
using System;
using System.Collections.Generic;
using System.Linq;

namespace NetMQExample
{
    /// <summary>An action is to rest, or to run left, right, down or up. Seen is the own place and energy; then of each
    /// of the others, in the order of the names, where it is from here, and 1 as long as it is in the game.</summary>
    public sealed class Pursuit : IAgentSimulation
    {
        // The world goes from -1 to 1, both ways; in one step a hunter comes so far, and a rabbit.
        private const double HunterRun = 0.05, RabbitRun = 0.06;
        // Nearer than this a rabbit is caught. A step costs a hunter, who begins with 1, this if he runs or rests.
        private const double Reach = 0.1, Running = 0.03, Resting = 0.01;
        private const int Size = 200;
        private static readonly (int Right, int Up)[] Ways = { (0, 0), (-1, 0), (1, 0), (0, -1), (0, 1) };

        private readonly Player[] players = new[] { "hunter_0", "hunter_1", "hunter_2", "rabbit_0", "rabbit_1" }
            .Select(name => new Player(name)).ToArray();
        private List<Player> gone = new List<Player>();

        /// <summary>Five players in the middle, until it is reset.</summary>
        public Pursuit()
        {
            var most = Enumerable.Repeat(2.0, 3 * players.Length).ToArray();
            var seen = GymSpace.Box(Array.ConvertAll(most, each => -each), most);
            Agents = players.Select(player => (player.Name, seen, GymSpace.Discrete(Ways.Length))).ToList();
        }

        /// <inheritdoc/>
        public string Name => "Pursuit";

        /// <inheritdoc/>
        public double Dt => 0.1;

        /// <inheritdoc/>
        public IReadOnlyList<(string Name, GymSpace Observation, GymSpace Action)> Agents { get; }

        /// <inheritdoc/>
        public InfoQueue Infos { get; } = new InfoQueue();

        private IEnumerable<Player> Hunters => players.Where(player => player.Hunts && player.Lives);

        private IEnumerable<Player> Rabbits => players.Where(player => !player.Hunts && player.Lives);

        /// <summary>An agent's place, and whether it is still in the game.</summary>
        public (double X, double Y, bool Lives) Place(string agent)
        {
            var player = Find(agent);
            return (player.X, player.Y, player.Lives);
        }

        /// <inheritdoc/>
        public void ResetWorld(RandomGenerator random, IReadOnlyDictionary<string, object> options)
        {
            foreach (var player in players)
            {
                (player.X, player.Y) = (2 * random.Next() - 1, 2 * random.Next() - 1);
                player.Energy = 1;
                player.Reward = 0;
                player.Lives = true;
            }
        }

        /// <inheritdoc/>
        public void Apply(IReadOnlyDictionary<string, SpaceReader> actions)
        {
            foreach (var player in players.Where(player => actions.ContainsKey(player.Name)))
            {
                var (right, up) = Ways[(int)actions[player.Name][0]];
                var far = player.Hunts ? HunterRun : RabbitRun;
                player.X = Math.Min(1, Math.Max(-1, player.X + right * far));
                player.Y = Math.Min(1, Math.Max(-1, player.Y + up * far));
                player.Reward = player.Hunts ? -0.01 : 0.01;
                var tired = right == 0 && up == 0 ? Resting : Running;
                if (player.Hunts) player.Energy = Math.Max(0, player.Energy - tired);
            }
            gone = Hunters.Where(hunter => hunter.Energy <= 0).ToList();
            foreach (var rabbit in Rabbits) Catch(rabbit);
            foreach (var player in gone) player.Lives = false;
        }

        private void Catch(Player rabbit)
        {
            var near = Hunters.Where(hunter => Distance(hunter, rabbit) < Reach).ToList();
            if (near.Count == 0) return;
            foreach (var hunter in near) hunter.Reward += 10.0 / near.Count;
            rabbit.Reward = -10;
            gone.Add(rabbit);
            Infos.Send("", new Dictionary<string, object> { ["caught"] = rabbit.Name, ["by"] = near[0].Name });
        }

        /// <inheritdoc/>
        public void Observe(string agent, SpaceWriter seen)
        {
            var self = Find(agent);
            seen.Add(self.X, self.Y, self.Energy);
            foreach (var player in players)
                if (player != self) seen.Add(player.X - self.X, player.Y - self.Y, player.Lives ? 1 : 0);
        }

        /// <inheritdoc/>
        public (double Reward, bool Terminated, bool Truncated) RewardAndEnd(
            string agent, IDictionary<string, object> info) =>
            (Find(agent).Reward, gone.Contains(Find(agent)) || !Hunters.Any() || !Rabbits.Any(), false);

        /// <inheritdoc/>
        public void OnInfo(string agent, IReadOnlyDictionary<string, object> info) { }

        /// <inheritdoc/>
        public MessageArray Render()
        {
            var pixels = new byte[Size * Size * 3];
            for (var i = 0; i < pixels.Length; i += 3) new byte[] { 90, 140, 70 }.CopyTo(pixels, i);
            foreach (var player in players.Where(player => player.Lives))
            {
                var colour = player.Hunts ? new byte[] { 180, 40, 40 } : new byte[] { 240, 240, 240 };
                int x = (int)((1 + player.X) * (Size - 1) / 2), row = Size - 1 - (int)((1 + player.Y) * (Size - 1) / 2);
                for (var y = Math.Max(0, row - 4); y < Math.Min(Size, row + 5); y++)
                    for (var at = Math.Max(0, x - 4); at < Math.Min(Size, x + 5); at++)
                        colour.CopyTo(pixels, (y * Size + at) * 3);
            }
            return new MessageArray("uint8", pixels, Size, Size, 3);
        }

        private static double Distance(Player one, Player other)
        {
            var (x, y) = (one.X - other.X, one.Y - other.Y);
            return Math.Sqrt(x * x + y * y);
        }

        private Player Find(string agent) => players.First(player => player.Name == agent);

        private sealed class Player
        {
            public readonly string Name;
            public readonly bool Hunts;
            public double X, Y, Energy, Reward;
            public bool Lives;

            public Player(string name)
            {
                Name = name;
                Hunts = name.StartsWith("hunter", StringComparison.Ordinal);
            }
        }
    }
}
