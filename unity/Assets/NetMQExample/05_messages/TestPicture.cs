// The request of lesson 05's clients, and their line about the reply: both are only for the lesson.
using System;
using System.Linq;

namespace NetMQExample
{
    /// <summary>A picture of 320 x 240 pixels, grey with a white square that moves.</summary>
    public static class TestPicture
    {
        private const int Width = 320, Height = 240;

        public static Message Request(int number)
        {
            var request = new Message("frame", number);
            request.Values["bottom_up"] = true;
            request.Arrays.Add(new MessageArray("uint8", Pixels(number), Height, Width, 3));
            return request;
        }

        // RGB, the lowest row first, as Unity's textures have it.
        private static byte[] Pixels(int number)
        {
            var pixels = new byte[Height * Width * 3];
            Array.Fill(pixels, (byte)(number % 20 * 10));
            int left = number % 20 * 16, top = number % 30 * 8;
            for (var y = top; y < top + 8; y++)
                Array.Fill(pixels, (byte)255, ((Height - 1 - y) * Width + left) * 3, 24);
            return pixels;
        }

        public static string Line(int number, Message reply)
        {
            var found = reply.Values.Select(value => FormattableString.Invariant($"{value.Key} {value.Value}"));
            var printable = LogText.Printable(string.Join(", ", found));
            return $"{number}: sent frame {number}, {Width * Height * 3} bytes; brightest at {printable}";
        }
    }
}
