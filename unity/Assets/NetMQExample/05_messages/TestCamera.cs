// Stands for a camera in lesson 05: grey pictures with a white square that moves, and how they are asked about.
using System;
using System.Diagnostics;
using System.Linq;

namespace NetMQExample
{
    /// <summary>Counts pictures: some a second, whether anybody looks or not; with 0 one for each look.</summary>
    public sealed class TestCamera
    {
        /// <summary>The pictures' measures in pixels, and their bytes.</summary>
        public const int Width = 320, Height = 240, Size = Width * Height * 3;

        private readonly Stopwatch clock = Stopwatch.StartNew();
        private readonly int fps;

        /// <summary>Begins to count.</summary>
        public TestCamera(int fps) => this.fps = fps;

        /// <summary>The number of the newest picture that was asked for.</summary>
        public int Number { get; private set; }

        /// <summary>True if there is a newer picture than before. Those in between are skipped.</summary>
        public bool Look()
        {
            var newest = fps == 0 ? Number + 1 : (int)(clock.Elapsed.TotalSeconds * fps);
            var newer = newest > Number;
            Number = Math.Max(newest, Number);
            return newer;
        }

        /// <summary>Draws RGB pixels, the lowest row first, as Unity's textures have it.</summary>
        public static void Draw(byte[] pixels, int number)
        {
            Array.Fill(pixels, (byte)(number % 20 * 10));
            int left = number % 20 * 16, top = number % 30 * 8;
            for (var y = top; y < top + 8; y++)
                Array.Fill(pixels, (byte)255, ((Height - 1 - y) * Width + left) * 3, 24);
        }

        /// <summary>Pixels as a request. The server turns them over, which costs it nothing.</summary>
        public static Message Frame(int number, byte[] pixels)
        {
            var request = new Message("frame", number);
            request.Values["bottom_up"] = true;
            request.Arrays.Add(new MessageArray("uint8", pixels, Height, Width, 3));
            return request;
        }

        /// <summary>A JPEG file as a request. Such a file has its top row first, in Unity as everywhere.</summary>
        public static Message Jpeg(int number, byte[] file)
        {
            var request = new Message("jpeg", number);
            request.Arrays.Add(new MessageArray("uint8", file, file.Length));
            return request;
        }

        /// <summary>The line to print about an exchange. A server of your own may answer with something else.</summary>
        public static string Describe(int i, Message sent, Message reply)
        {
            var (all, what) = (reply.Values, $"{sent.Kind} {sent.Id}, {sent.Arrays[0].Data.Length} bytes");
            var each = all.Select(value => FormattableString.Invariant($"{value.Key} {value.Value}"));
            var found = string.Join(", ", each);
            if (all.ContainsKey("x") && all.ContainsKey("y") && all.TryGetValue("mean", out var mean) &&
                (mean is double || mean is long))
                found = FormattableString.Invariant($"brightest at x {all["x"]}, y {all["y"]}, mean {mean:F1}");
            return $"{i}: sent {what}; {NetMQLifetime.Printable(found == "" ? "no values" : found)}";
        }
    }
}
