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

        public void OnReset(RandomGenerator random, IReadOnlyDictionary<string, object> options)
        {
            foreach (var player in players) player.Begin(random);
        }

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

        public void OnStepped() { }

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

    /// <summary>An action is to rest, or to run left, right, down or up. Seen is the own place and energy; then of each
    /// of the others, in the order of the names, where it is from here, and 1 as long as it is in the game.</summary>
    public sealed class PursuitPlayer : PlainAgent
    {
        // In one step a hunter comes so far, and a rabbit. A hunter begins with 1, and pays this when he runs or rests.
        private const double HunterRun = 0.05, RabbitRun = 0.06, Running = 0.03, Resting = 0.01;
        private static readonly (int Right, int Up)[] Ways = { (0, 0), (-1, 0), (1, 0), (0, -1), (0, 1) };

        private readonly Pursuit world;
        // Before the first action it has none, and stays.
        private int? way;
        private bool begun;

        internal PursuitPlayer(Pursuit world, string name) : base(name)
        {
            this.world = world;
            Hunts = name.StartsWith("hunter", StringComparison.Ordinal);
        }

        public bool Hunts { get; }

        /// <summary>Where it is: from -1, left, to 1, right.</summary>
        public double X { get; private set; }

        /// <summary>From -1, below, to 1, above.</summary>
        public double Y { get; private set; }

        public bool Lives { get; internal set; }

        public override GymSpace Observation { get; } = GymSpace.Box(-2, 2, 15);

        public override GymSpace Action { get; } = GymSpace.Discrete(Ways.Length);

        // A hunter's energy, and the reward of this tick.
        internal double Energy { get; private set; } = 1;

        internal double Earned { get; set; }

        public override void OnReset()
        {
            // A player that begins anew while the others go on has no place from the world.
            if (!begun) Begin(Rng);
            begun = false;
        }

        public override void OnAction(SpaceReader action) => way = (int)action[0];

        public override void Observe(SpaceWriter seen)
        {
            seen.Add(X, Y, Energy);
            foreach (var other in world.Players)
                if (other != this) seen.Add(other.X - X, other.Y - Y, other.Lives ? 1 : 0);
        }

        internal void Begin(RandomGenerator random)
        {
            (X, Y) = (2 * random.Next() - 1, 2 * random.Next() - 1);
            (Energy, Lives, begun, way) = (1, true, true, null);
        }

        internal void Move()
        {
            if (!(way is int wanted)) return;
            var (right, up) = Ways[wanted];
            var far = Hunts ? HunterRun : RabbitRun;
            X = Math.Min(1, Math.Max(-1, X + right * far));
            Y = Math.Min(1, Math.Max(-1, Y + up * far));
            Earned = Hunts ? -0.01 : 0.01;
            if (Hunts) Energy = Math.Max(0, Energy - (wanted == 0 ? Resting : Running));
        }

        internal void Judge(bool over)
        {
            AddReward(Earned);
            Earned = 0;
            if (over || !Lives) Terminate();
        }
    }
}
