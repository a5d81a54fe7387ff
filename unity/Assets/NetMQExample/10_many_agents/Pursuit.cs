// Lesson 10, the game: three hunters, two rabbits, and a meadow with a fence. In Python: pursuit.py.
//
// Rabbits are faster, so hunters must drive them into a corner. A hunter who runs tires, and one without energy is out;
// a rabbit that is caught is out as well. The game ends when all rabbits are caught, or no hunter is left.
// All move at once: a player remembers in OnAction what it wants, and the world moves them all in its OnTick.
// Both sides give the same numbers to the last bit: there is nothing but plus, minus, times, divide and square root.
// Your own game takes its place.
using System;
using System.Collections.Generic;
using System.Linq;

namespace NetMQExample
{
    /// <summary>The meadow. It goes from -1 to 1, both ways.</summary>
    public sealed class Pursuit : IWorld
    {
        // Nearer than this a rabbit is caught.
        private const double Reach = 0.1;
        private const int Size = 200;

        private readonly PursuitPlayer[] players;

        /// <summary>Five players in the middle, until it is reset.</summary>
        public Pursuit() => players = new[] { "hunter_0", "hunter_1", "hunter_2", "rabbit_0", "rabbit_1" }
            .Select(name => new PursuitPlayer(this, name)).ToArray();

        /// <summary>The agents: three hunters, and two rabbits.</summary>
        public IReadOnlyList<PursuitPlayer> Players => players;

        /// <summary>Tells Python who was caught. A simulator's SendInfo does.</summary>
        public Action<object> SendInfo { get; set; } = info => { };

        private IEnumerable<PursuitPlayer> Hunters => players.Where(player => player.Hunts && player.Lives);

        private IEnumerable<PursuitPlayer> Rabbits => players.Where(player => !player.Hunts && player.Lives);

        /// <inheritdoc/>
        public void OnReset(RandomGenerator random, IReadOnlyDictionary<string, object> options)
        {
            foreach (var player in players) player.Begin(random);
        }

        /// <inheritdoc/>
        public void OnTick(double dt)
        {
            var living = players.Where(player => player.Lives).ToList();
            foreach (var player in living) player.Move();
            var gone = Hunters.Where(hunter => hunter.Energy <= 0).ToList();
            foreach (var rabbit in Rabbits)
            {
                var near = Hunters.Where(hunter => Distance(hunter, rabbit) < Reach).ToList();
                if (near.Count == 0) continue;
                foreach (var hunter in near) hunter.Earned += 10.0 / near.Count;
                rabbit.Earned = -10;
                gone.Add(rabbit);
                SendInfo(new Dictionary<string, object> { ["caught"] = rabbit.Name, ["by"] = near[0].Name });
            }
            foreach (var player in gone) player.Lives = false;
            var over = !Hunters.Any() || !Rabbits.Any();
            foreach (var player in living) player.Judge(over);
        }

        /// <inheritdoc/>
        public void OnStepped() { }

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

        private static double Distance(PursuitPlayer one, PursuitPlayer other)
        {
            var (x, y) = (one.X - other.X, one.Y - other.Y);
            return Math.Sqrt(x * x + y * y);
        }
    }
}
