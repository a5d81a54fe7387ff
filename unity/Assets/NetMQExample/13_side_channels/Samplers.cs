// Lesson 13, samplers: numbers drawn by chance, the same for the same seed in Python and C#.
//
// ML-Agents' own are drawn by System.Random, so the same seed gives others there, spread in the same way.
// The Python side is unity_channels.py.
using System;
using System.Collections.Generic;
using System.Linq;

namespace NetMQExample.SideChannels
{
    /// <summary>Makes samplers: functions that give another number each time.</summary>
    public static class Samplers
    {
        /// <summary>From one number to another, all as likely.</summary>
        public static Func<float> Uniform(float low, float high, int seed)
        {
            Check(low, high);
            var chance = Draws(seed);
            return () => (float)(low + (chance() * ((double)high - low)));
        }

        /// <summary>The sum of twelve numbers from 0 to 1 is bell-shaped with deviation 1, and needs no logarithm:
        /// those of two systems differ in the last bit.</summary>
        public static Func<float> Gaussian(float mean, float stDev, int seed)
        {
            Check(mean, stDev);
            var chance = Draws(seed);
            return () =>
            {
                var total = -6.0;
                for (var i = 0; i < 12; i++) total += chance();
                return (float)(mean + (stDev * total));
            };
        }

        /// <summary>From several intervals, low, high, low, high …: a longer one is hit more often.</summary>
        public static Func<float> MultiRangeUniform(IList<float> bounds, int seed)
        {
            Check(bounds.ToArray());
            var wrong = bounds.Count == 0 || bounds.Count % 2 != 0;
            var length = 0.0;
            for (var i = 0; i < bounds.Count && !wrong; i += 2)
            {
                wrong = bounds[i] > bounds[i + 1];
                length += (double)bounds[i + 1] - bounds[i];
            }
            if (wrong) throw new UnityAgentsException("ranges are pairs of a lower and a higher number");
            var chance = Draws(seed);
            return () =>
            {
                var (at, i) = (chance() * length, 0);
                for (; i < bounds.Count - 2 && at > (double)bounds[i + 1] - bounds[i]; i += 2)
                    at -= (double)bounds[i + 1] - bounds[i];
                return (float)Math.Min(bounds[i] + at, bounds[i + 1]);
            };
        }

        private static void Check(params float[] numbers)
        {
            if (numbers.Any(number => float.IsNaN(number) || float.IsInfinity(number)))
                throw new UnityAgentsException("a sampler takes numbers, not NaN or infinity");
        }

        // Numbers from 0 to 1, the same in every language: SplitMix64 (Steele, Lea and Flood, 2014).
        private static Func<double> Draws(int seed)
        {
            var state = unchecked((ulong)seed);
            return () =>
            {
                unchecked
                {
                    state += 0x9E3779B97F4A7C15;
                    var bits = (state ^ state >> 30) * 0xBF58476D1CE4E5B9;
                    bits = (bits ^ bits >> 27) * 0x94D049BB133111EB;
                    return ((bits ^ bits >> 31) >> 11) / 9007199254740992.0;
                }
            };
        }
    }
}
