// Lesson 10, somebody of the game: a hunter, or a rabbit.
using System;

namespace NetMQExample
{
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

        /// <summary>Whether it is a hunter.</summary>
        public bool Hunts { get; }

        /// <summary>Where it is: from -1, left, to 1, right.</summary>
        public double X { get; private set; }

        /// <summary>From -1, below, to 1, above.</summary>
        public double Y { get; private set; }

        /// <summary>Whether it is still in the game.</summary>
        public bool Lives { get; internal set; }

        /// <inheritdoc/>
        public override GymSpace Observation { get; } = GymSpace.Box(-2, 2, 15);

        /// <inheritdoc/>
        public override GymSpace Action { get; } = GymSpace.Discrete(Ways.Length);

        // What a hunter has left, and what was earned in this tick.
        internal double Energy { get; private set; } = 1;

        internal double Earned { get; set; }

        /// <inheritdoc/>
        public override void OnReset()
        {
            // Who begins anew while the others go on has no place from the world.
            if (!begun) Begin(Rng);
            begun = false;
        }

        /// <inheritdoc/>
        public override void OnAction(SpaceReader action) => way = (int)action[0];

        /// <inheritdoc/>
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
