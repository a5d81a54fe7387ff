// Lesson 09, the world: a pole on a cart, pushed left or right. In Python: cart_pole.py.
//
// The equations are those of Gymnasium's CartPole-v1 (Barto, Sutton and Anderson, 1983; Florian, 2007): from the same
// state, the same actions lead to the same states. Sine and cosine differ in their last bit from one system to the
// next, so two systems agree to many digits and not to all. Your own simulation takes its place.
using System;
using System.Globalization;

namespace NetMQExample
{
    /// <summary>Where cart and pole are, and how they move: an agent without Unity.</summary>
    public sealed class CartPole : PlainAgent
    {
        private const double Gravity = 9.8, Force = 10, Cart = 1, Pole = 0.1, HalfLength = 0.5;
        // The episode is over when the cart leaves the track, in metres, or the pole falls: 12 degrees.
        private const double Track = 2.4, Fall = 12 * 2 * Math.PI / 360;
        private const int Width = 300, Height = 200, Scale = 60;
        // Twice as far as an episode goes, so that its last observation is in the space as well. Any finite speed: of
        // an infinite one Gymnasium's checker warns.
        private static readonly double[] Most = { 2 * Track, float.MaxValue, 2 * Fall, float.MaxValue };

        private double push, speed, turning;

        /// <summary>At rest in the middle, until it is reset.</summary>
        public CartPole(string name = "agent") : base(name) { }

        /// <summary>The middle of the cart, in metres.</summary>
        public double Place { get; private set; }

        /// <summary>From upright, to the right, in radians.</summary>
        public double Angle { get; private set; }

        protected override int StateSize => 4;

        public override GymSpace Observation { get; } = GymSpace.Box(Array.ConvertAll(Most, most => -most), Most);

        public override GymSpace Action { get; } = GymSpace.Discrete(2);

        public override void OnReset()
        {
            double low = Option("low", -0.05), high = Option("high", 0.05);
            double Drawn() => low + (high - low) * Rng.Next();
            var state = FirstState.Length > 0 ? FirstState : new[] { Drawn(), Drawn(), Drawn(), Drawn() };
            (Place, speed, Angle, turning) = (state[0], state[1], state[2], state[3]);
            push = 0;
        }

        public override void OnAction(SpaceReader action) => push = action[0] == 1 ? Force : -Force;

        public override void OnTick(double dt)
        {
            double sine = Math.Sin(Angle), cosine = Math.Cos(Angle);
            var forward = (push + Pole * HalfLength * (turning * turning) * sine) / (Cart + Pole);
            var around = (Gravity * sine - cosine * forward) /
                (HalfLength * (4.0 / 3 - Pole * (cosine * cosine) / (Cart + Pole)));
            forward -= Pole * HalfLength * around * cosine / (Cart + Pole);
            Place += dt * speed;
            speed += dt * forward;
            Angle += dt * turning;
            turning += dt * around;
        }

        public override void OnStepped()
        {
            AddReward(1);
            if (Math.Abs(Place) > Track || Math.Abs(Angle) > Fall) Terminate();
        }

        public override void Observe(SpaceWriter seen) => seen.Add(Place, speed, Angle, turning);

        public override MessageArray Render()
        {
            var pixels = new byte[Height * Width * 3];
            Array.Fill(pixels, (byte)255);
            // A rectangle around a place in pixels, y upwards; what is outside is left out.
            void Fill(double x, double y, int width, int height, byte red, byte green, byte blue)
            {
                int left = (int)x - width / 2, top = Height - (int)y - height / 2;
                for (var row = Math.Max(0, top); row < Math.Min(Height, top + height); row++)
                    for (var column = Math.Max(0, left); column < Math.Min(Width, left + width); column++)
                        new[] { red, green, blue }.CopyTo(pixels, (row * Width + column) * 3);
            }
            var middle = Width / 2.0 + Scale * Place;
            Fill(Width / 2.0, 50, Width, 2, 0, 0, 0);
            Fill(middle, 50, 50, 30, 40, 60, 90);
            for (var along = 0; along < 2 * Scale; along++)
                Fill(middle + along * Math.Sin(Angle), 60 + along * Math.Cos(Angle), 6, 6, 200, 140, 80);
            return new MessageArray("uint8", pixels, Height, Width, 3);
        }

        private double Option(string name, double standard)
        {
            if (!Options.TryGetValue(name, out var given)) return standard;
            if (!(given is string)) return Convert.ToDouble(given, CultureInfo.InvariantCulture);
            throw new MessageException("bad-option", "low and high are numbers, between which an episode begins");
        }
    }
}
