// Application 20, one pose of one person or hand: read from its message, turned into Unity's axes, and measured.
//
// Bytes: UTF-8 text, one frame: `pose/PERSON/ NUMBER SECONDS`, and then `x y z visibility` for each of the 33 landmarks
// that MediaPipe numbers; without them nobody is there. `hand/left/` and `hand/right/` have 21. Take home: this file.
// It needs neither NetMQ nor UnityEngine. The Python side is python/20_body_tracking/server.py, whose header says more.
using System;
using System.Globalization;

namespace NetMQExample
{
    /// <summary>33 landmarks in metres from the middle of the hips, or a hand's 21 from its middle, in Unity's
    /// axes.</summary>
    public sealed class BodyPose
    {
        /// <summary>How many landmarks a body has, and a hand.</summary>
        public const int Landmarks = 33, OfAHand = 21;

        // In front of the landmarks' words.
        private const int Before = 3;

        private BodyPose(long number, double seconds, double[] places, double[] visibility) =>
            (Number, Seconds, Places, Visibility) = (number, seconds, places, visibility);

        /// <summary>Counts the server's poses from 1.</summary>
        public long Number { get; }

        /// <summary>When it was taken, since the server's start.</summary>
        public double Seconds { get; }

        /// <summary>x, y and z of each landmark; null if nobody is there.</summary>
        public double[] Places { get; }

        /// <summary>How sure it is that each landmark is seen, from 0 to 1; null if nobody is there.</summary>
        public double[] Visibility { get; }

        /// <summary>Reads a message.</summary>
        /// <param name="message">What the server has published.</param>
        /// <returns>Null for what is no pose, since anybody can publish on a port.</returns>
        public static BodyPose Parse(string message)
        {
            var words = message.Split(' ');
            var hand = words[0].StartsWith("hand/", StringComparison.Ordinal);
            var count = hand ? OfAHand : Landmarks;
            var there = words.Length == Before + 4 * count;
            if (!(there || words.Length == Before) || !(hand || words[0].StartsWith("pose/", StringComparison.Ordinal))
                || !long.TryParse(words[1], NumberStyles.None, CultureInfo.InvariantCulture, out var number)
                || !TryRead(words[2], out var seconds)) return null;
            if (!there) return new BodyPose(number, seconds, null, null);
            var (places, visibility) = (new double[3 * count], new double[count]);
            for (var i = 0; i < count; i++)
            {
                var word = Before + 4 * i;
                if (!TryRead(words[word], out places[3 * i]) || !TryRead(words[word + 1], out var down)
                    || !TryRead(words[word + 2], out places[3 * i + 2])
                    || !TryRead(words[word + 3], out visibility[i])) return null;
                // MediaPipe's y points down, Unity's up. That also makes its right-handed axes left-handed ones.
                places[3 * i + 1] = -down;
            }
            return new BodyPose(number, seconds, places, visibility);
        }

        /// <summary>How far a limb is bent open at landmark b, in degrees; 180 is straight.</summary>
        public double Angle(int a, int b, int c)
        {
            double dot = 0, one = 0, other = 0;
            for (var i = 0; i < 3; i++)
            {
                var (first, last) = (Places[3 * a + i] - Places[3 * b + i], Places[3 * c + i] - Places[3 * b + i]);
                (dot, one, other) = (dot + first * last, one + first * first, other + last * last);
            }
            var lengths = Math.Sqrt(one) * Math.Sqrt(other);
            return lengths > 0 ? Math.Acos(Math.Max(-1, Math.Min(1, dot / lengths))) * 180 / Math.PI : 0;
        }

        // Without the culture, a German machine reads 0.5 as 5. And no body is a kilometre long.
        private static bool TryRead(string word, out double value) =>
            double.TryParse(word, NumberStyles.AllowLeadingSign | NumberStyles.AllowDecimalPoint,
                CultureInfo.InvariantCulture, out value) && Math.Abs(value) < 1e9;
    }
}
