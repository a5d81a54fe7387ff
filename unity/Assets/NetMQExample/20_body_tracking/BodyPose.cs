// Application 20, one pose of one person or hand: read from its message, turned into Unity's axes, and measured.
//
// Bytes: UTF-8 text, one frame: `pose/PERSON/ NUMBER SECONDS`, and then `x y z visibility` for each of the 33 landmarks
// that MediaPipe numbers; without them nobody is there. `hand/left/` and `hand/right/` have 21.
// It needs neither NetMQ nor UnityEngine. The Python side is python/20_body_tracking/server.py, whose header says more.
using System;
using System.Globalization;
using System.Text.RegularExpressions;

namespace NetMQExample
{
    /// <summary>33 landmarks in metres from the middle of the hips, or a hand's 21 from its middle, in Unity's
    /// axes.</summary>
    public sealed class BodyPose
    {
        /// <summary>How many landmarks a body has, and a hand.</summary>
        public const int Landmarks = 33, OfAHand = 21;

        // Plain numbers, as Python reads them: TryParse also takes +5, .5 and Infinity.
        private static readonly Regex Form = new Regex(@"^(?:pose/[0-9]+|(hand)/(?:left|right))/ ([0-9]{1,18}) "
            + @"([0-9]{1,9}\.[0-9]{1,9})((?: -?[0-9]{1,9}(?:\.[0-9]{1,9})?)*)\z");

        private BodyPose(long number, double seconds, double[] places, double[] visibility)
        {
            Number = number;
            Seconds = seconds;
            Places = places;
            Visibility = visibility;
        }

        /// <summary>Counts the server's poses from 1.</summary>
        public long Number { get; }

        /// <summary>When it was taken, by the server's clock.</summary>
        public double Seconds { get; }

        /// <summary>x, y and z of each landmark; null if nobody is there.</summary>
        public double[] Places { get; }

        /// <summary>How sure it is that each landmark is seen, from 0 to 1; null if nobody is there.</summary>
        public double[] Visibility { get; }

        /// <summary>Reads a message.</summary>
        /// <returns>Null if it is no pose, since anybody can publish on a port.</returns>
        public static BodyPose Parse(string message)
        {
            var parts = Form.Match(message);
            if (!parts.Success) return null;
            var count = parts.Groups[1].Success ? OfAHand : Landmarks;
            // In front of the first number is a space too: the first word is none.
            var words = parts.Groups[4].Value.Split(' ');
            if (words.Length != 1 && words.Length != 1 + 4 * count) return null;
            var number = long.Parse(parts.Groups[2].Value, CultureInfo.InvariantCulture);
            var seconds = Read(parts.Groups[3].Value);
            if (words.Length == 1) return new BodyPose(number, seconds, null, null);
            var places = new double[3 * count];
            var visibility = new double[count];
            for (var i = 0; i < count; i++)
            {
                var word = 1 + 4 * i;
                // MediaPipe's y points down, Unity's up. That also makes its right-handed axes left-handed ones.
                places[3 * i] = Read(words[word]);
                places[3 * i + 1] = -Read(words[word + 1]);
                places[3 * i + 2] = Read(words[word + 2]);
                visibility[i] = Read(words[word + 3]);
            }
            return new BodyPose(number, seconds, places, visibility);
        }

        /// <summary>How far a limb is bent open at landmark b, in degrees; 180 is straight.</summary>
        public double Angle(int a, int b, int c)
        {
            double dot = 0, one = 0, other = 0;
            for (var i = 0; i < 3; i++)
            {
                var first = Places[3 * a + i] - Places[3 * b + i];
                var last = Places[3 * c + i] - Places[3 * b + i];
                dot += first * last;
                one += first * first;
                other += last * last;
            }
            var lengths = Math.Sqrt(one) * Math.Sqrt(other);
            return lengths > 0 ? Math.Acos(Math.Max(-1, Math.Min(1, dot / lengths))) * 180 / Math.PI : 0;
        }

        // Without the culture, a German machine reads 0.5 as 5.
        private static double Read(string word) => double.Parse(word, CultureInfo.InvariantCulture);
    }
}
