// Lesson 12, the world: lesson 08's car drives along its road by itself, seen by two views.
//
// The Python side is self_driving.py, and its pictures are the same to the last byte. Your own game takes its place.
// Unity's real cameras look at the same drive; the drawn ones are for the terminal.
using System;

namespace NetMQExample
{
    /// <summary>A step takes <see cref="Drive.StepSeconds"/>.</summary>
    public sealed class SelfDriving
    {
        // It aims at a point of the road some 6 m ahead, and drives at 8 m/s. Lesson 08's car turns that much at most.
        private const int Ahead = 40;
        private const double Speed = 8, Curvature = 0.16;
        // The map: pixels of a metre, and where the world's corner is in it.
        private const int Scale = 2, Left = 40, Low = 20;
        private static readonly byte[] Grass = { 70, 120, 50 }, Tarmac = { 90, 90, 95 }, Red = { 200, 30, 30 };

        private readonly Road road = new Road();
        private readonly byte[] drawn = new byte[DrawnCamera.Size], ground = new byte[DrawnCamera.Size];
        private DrawnCamera camera;

        public SelfDriving()
        {
            Car = new Car(road, 0);
            for (var at = 0; at < ground.Length; at += 3) Grass.CopyTo(ground, at);
            foreach (var (x, y) in road.Points) Square(ground, x, y, 4, Tarmac);
        }

        public Car Car { get; }
        public int Steps { get; private set; }

        public void Step()
        {
            var (toX, toY) = road.Points[(road.Nearest(Car.X, Car.Y).At + Ahead) % road.Points.Length];
            double x = toX - Car.X, y = toY - Car.Y;
            // Along the circle that leads there.
            var steer = 2 * (x * Car.AheadY - y * Car.AheadX) / (x * x + y * y) / Curvature;
            Car.Step(Math.Clamp(Speed + 0.4 - Car.Speed, 0, 1), 0, Math.Clamp(steer, -1, 1));
            Steps++;
        }

        /// <summary>The picture of a camera on the car, with the number of the step in its upper corner.</summary>
        public void DrawFront(Picture picture)
        {
            // It paints its ground once, and Unity does not need it.
            camera ??= new DrawnCamera(road);
            camera.Draw(drawn, Car, Steps);
            Shrink(picture);
        }

        /// <summary>All of the road from above, and where the car is.</summary>
        public void DrawMap(Picture picture)
        {
            ground.CopyTo(drawn, 0);
            Square(drawn, Car.X, Car.Y, 3, Red);
            Shrink(picture);
        }

        private static void Square(byte[] pixels, double x, double y, int half, byte[] colour)
        {
            int column = Left + (int)(x * Scale), row = Low + (int)(y * Scale);
            for (var i = row - half; i <= row + half; i++)
                for (var k = column - half; k <= column + half; k++)
                    colour.CopyTo(pixels, (i * DrawnCamera.Width + k) * 3);
        }

        // Of each place the nearest pixel.
        private void Shrink(Picture picture)
        {
            var width = picture.Film.Width;
            var height = picture.Film.Height;
            var at = 0;
            for (var row = 0; row < height; row++)
                for (var column = 0; column < width; column++, at += 3)
                {
                    int y = row * DrawnCamera.Height / height, x = column * DrawnCamera.Width / width;
                    Buffer.BlockCopy(drawn, (y * DrawnCamera.Width + x) * 3, picture.Pixels, at, 3);
                }
        }
    }
}
