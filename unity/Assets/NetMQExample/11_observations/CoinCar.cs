// Lesson 11, the world: a car that collects coins on a field of 10 by 10 m. In Python: worlds/coin_car.py.
//
// Its members say what is seen of them. Your own agent takes its place.
using System;
using System.Collections.Generic;

namespace NetMQExample
{
    /// <summary>Where the car and the coins are.</summary>
    public class CoinCar : PlainAgent
    {
        /// <summary>How long and wide the field is, in metres.</summary>
        public const double Field = 10;

        private const int Coins = 3;
        private const double Reach = 0.5, Speed = 3;

        [Obs(".last.push")] private float[] push = new float[2];
        [Discrete(".last.boost")] private long boost;
        [Text] private string says = "";
        private double x, y;
        private int steps;

        public CoinCar(string name = "agent") : base(name) { }

        public List<(double X, double Y)> Spots { get; } = new List<(double X, double Y)>();

        public (double X, double Y) Spot => (x, y);

        [Box] private float[] place => new[] { (float)x, (float)y };
        [Discrete] private int left => Spots.Count;
        [List] private List<float[]> coins => Spots.ConvertAll(spot => new[] { (float)spot.X, (float)spot.Y });

        public override void OnReset()
        {
            (x, y) = (Field / 2, Field / 2);
            Spots.Clear();
            for (var i = 0; i < Coins; i++)
                Spots.Add((1 + 8 * Rng.Next(), 1 + 8 * Rng.Next()));
            push = new float[2];
            boost = 0;
            says = "";
            steps = 0;
        }

        public override void OnAction(object action)
        {
            var parts = (Dictionary<string, object>)action;
            push = ((MessageArray)parts["push"]).Items<float>().ToArray();
            boost = (long)parts["boost"];
            steps++;
        }

        public override void OnTick(double dt)
        {
            var metres = Speed * (1 + boost) * dt;
            x = Math.Min(Field, Math.Max(0, x + push[0] * metres));
            y = Math.Min(Field, Math.Max(0, y + push[1] * metres));
            AddReward(-0.01);
            foreach (var (coinX, coinY) in Spots.ToArray())
            {
                if ((coinX - x) * (coinX - x) + (coinY - y) * (coinY - y) >= Reach * Reach) continue;
                Spots.Remove((coinX, coinY));
                AddReward(1);
                says = FormattableString.Invariant($"coin {Coins - Spots.Count} after {steps} steps");
                SendInfo(says);
            }
            if (Spots.Count == 0) Terminate();
        }
    }

    /// <summary>Where no camera is, it draws what one would see from above.</summary>
    public sealed class DrawnCoinCar : CoinCar
    {
        private static readonly byte[] Grass = { 40, 80, 40 }, Coin = { 240, 200, 40 }, Car = { 200, 30, 30 };
        private static readonly byte[,,] Meadow = Filled(new byte[48, 64, 3], 0, 0, 48, 64, Grass);

        public DrawnCoinCar(string name = "agent") : base(name) { }

        [Box(".camera")] private byte[,,] picture => Draw();

        // Uint8 [48, 64, 3], the highest row first.
        private byte[,,] Draw()
        {
            var pixels = (byte[,,])Meadow.Clone();
            foreach (var spot in Spots) Point(pixels, spot, Coin);
            Point(pixels, Spot, Car);
            return pixels;
        }

        private static void Point(byte[,,] pixels, (double X, double Y) spot, byte[] colour) =>
            Filled(pixels, (int)((Field - spot.Y) / Field * 44), (int)(spot.X / Field * 60), 4, 4, colour);

        private static byte[,,] Filled(byte[,,] pixels, int row, int column, int height, int width, byte[] colour)
        {
            for (var i = 0; i < height * width * 3; i++)
                pixels[row + i / 3 / width, column + i / 3 % width, i % 3] = colour[i % 3];
            return pixels;
        }
    }
}
