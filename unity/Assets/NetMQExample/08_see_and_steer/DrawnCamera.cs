// Lesson 08, the camera of the terminal: it draws what a camera on the car sees. In Unity a real Camera looks.
//
// The Python side is road.py, and its pictures are the same to the last byte.
using System;

namespace NetMQExample
{
    /// <summary>Draws the road in perspective, with its edges, its dashes and the horizon.</summary>
    public sealed class DrawnCamera
    {
        /// <summary>A picture's size in pixels, and its bytes: red, green and blue, the lowest row first.</summary>
        public const int Width = 320, Height = 240, Size = Width * Height * 3;

        // 1.5 m above the ground, tilted down by 16.26 degrees; how far it sees; metres of a cell of the ground.
        private const double Above = 1.5, Sine = 0.28, Cosine = 0.96, Far = 60, Cell = 0.1;
        private const int Columns = 1200, Rows = 1000;
        private static readonly byte[] Grass = { 70, 120, 50 }, Tarmac = { 90, 90, 95 }, Paint = { 230, 230, 225 };
        private static readonly byte[] Sky = { 150, 190, 230 };
        private static readonly byte[][] Colours = { Grass, Tarmac, Paint };

        // The ground from above, a byte for each cell: painted road edges, tarmac over them, and dashes.
        private readonly byte[,] ground = new byte[Rows, Columns];

        public DrawnCamera(Road road)
        {
            Require.Given("road", road);
            var layers = new[] { (Road.HalfWidth, 2, 1), (Road.HalfWidth - 0.2, 1, 1), (0.1, 2, 50) };
            foreach (var (radius, colour, every) in layers)
                for (var i = 0; i < road.Points.Length; i++)
                    if (every == 1 || i % every < every / 2) Disc(road.Points[i], radius, (byte)colour);
        }

        /// <summary>Room for the pictures of some cameras.</summary>
        public static CameraPictures Pictures(string cameras) => new CameraPictures(cameras, Width, Height, 3);

        /// <summary>Draws what each of these cameras sees now.</summary>
        public void Take(CameraPictures pictures, Drive drive, Car car)
        {
            drive.Note(pictures);
            for (var i = 0; i < pictures.Pixels.Length; i++)
                Draw(pictures.Pixels[i], car, (int)pictures.Frame, pictures.Right[i]);
        }

        /// <param name="pixels">Room for <see cref="Size"/> bytes.</param>
        /// <param name="number">Drawn as 16 squares, 1 in white, so that a picture says which one it is.</param>
        /// <param name="right">Metres to the right of the car's middle.</param>
        public void Draw(byte[] pixels, Car car, int number, double right = 0)
        {
            // 60 degrees from the upper edge to the lower one.
            var focal = Height / 2 * Math.Sqrt(3);
            var at = 0;
            for (var row = 0; row < Height; row++)
            {
                // Where the rays of this row meet the ground: how far ahead, and how far to the right.
                double up = (row + 0.5 - Height / 2) / focal, falls = Sine - up * Cosine;
                var seen = falls * Far > Above * (Cosine + up * Sine);
                double far = Above / falls, ahead = far * (Cosine + up * Sine);
                for (var column = 0; column < Width; column++, at += 3)
                {
                    var across = far * ((column + 0.5 - Width / 2) / focal) + right;
                    var colour = !seen ? Sky : Colours[At(
                        car.X + car.AheadX * ahead + car.AheadY * across,
                        car.Y + car.AheadY * ahead - car.AheadX * across)];
                    pixels[at] = colour[0];
                    pixels[at + 1] = colour[1];
                    pixels[at + 2] = colour[2];
                }
            }
            for (var y = Height - 8; y < Height; y++)
                for (var bit = 0; bit < 16; bit++)
                    Array.Fill(pixels, (byte)(255 * (number >> (15 - bit) & 1)), (y * Width + 8 * bit) * 3, 24);
        }

        private byte At(double x, double y)
        {
            int column = (int)(x / Cell), row = (int)(y / Cell);
            return x >= 0 && y >= 0 && column < Columns && row < Rows ? ground[row, column] : (byte)0;
        }

        private void Disc((double X, double Y) middle, double radius, byte colour)
        {
            var reach = (int)(radius / Cell) + 1;
            int left = (int)(middle.X / Cell), low = (int)(middle.Y / Cell);
            for (var y = -reach; y <= reach; y++)
                for (var x = -reach; x <= reach; x++)
                    if (x * x + y * y <= radius * radius / Cell / Cell) ground[low + y, left + x] = colour;
        }
    }
}
