// Lesson 08, the road: a closed curve, the same for Unity, for the terminal and for Python.
//
// Road.cs, Car.cs and DrawnCamera.cs are the lesson's world; your own takes their place. The Python side is
// road.py. Both give the same numbers to the last bit, because they only add, subtract, multiply, divide and take
// square roots of doubles: sine and cosine differ from one system to the next.
// Lengths are in metres, x to the right and y forward as seen from above: Unity's x and z.
using System;

namespace NetMQExample
{
    /// <summary>A smooth curve through a few corners (Catmull and Rom, 1974), as points some 0.15 m apart.</summary>
    public sealed class Road
    {
        /// <summary>From the middle of the road to its edge, in metres.</summary>
        public const double HalfWidth = 2.5;

        private const int Samples = 200;

        // The road goes through these points, and back from the last to the first.
        private static readonly (double X, double Y)[] Corners =
        {
            (20, 14), (52, 12), (92, 16), (110, 40), (92, 72), (66, 72), (50, 78), (32, 82), (10, 70), (12, 44),
        };

        public Road()
        {
            Points = new (double, double)[Corners.Length * Samples];
            for (var i = 0; i < Points.Length; i++)
            {
                (double X, double Y) Corner(int k) => Corners[(i / Samples + k) % Corners.Length];
                var (a, b, c, d) = (Corner(Corners.Length - 1), Corner(0), Corner(1), Corner(2));
                var t = i % Samples / (double)Samples;
                Points[i] = (Between(a.X, b.X, c.X, d.X, t), Between(a.Y, b.Y, c.Y, d.Y, t));
            }
        }

        /// <summary>The middle of the road; after the last point comes the first.</summary>
        public (double X, double Y)[] Points { get; }

        /// <summary>The number of the point that is nearest, and how far away it is in metres.</summary>
        public (int At, double Distance) Nearest(double x, double y)
        {
            var at = 0;
            var least = double.MaxValue;
            for (var i = 0; i < Points.Length; i++)
            {
                double right = Points[i].X - x, up = Points[i].Y - y, square = right * right + up * up;
                if (square < least) (at, least) = (i, square);
            }
            return (at, Math.Sqrt(least));
        }

        private static double Between(double a, double b, double c, double d, double t) =>
            ((((d - a + (b - c) * 3) * t + (a * 2 - b * 5 + c * 4 - d)) * t + (c - a)) * t + b * 2) / 2;
    }
}
