// Lesson 13, samplers: numbers drawn by chance, the same for the same seed in Python and C#.
//
// ML-Agents' own are drawn by System.Random, so the same seed gives others there, spread in the same way.
// The Python side is unity_channels.py.
using System;
using System.Collections.Generic;
using System.Linq;

namespace NetMQExample.MLAgents.SideChannels
{
    /// <summary>Makes samplers: functions that give another number each time.</summary>
    public static class Samplers
    {
        /// <summary>From one number to another, all as likely.</summary>
        public static Func<float> Uniform(float low, float high, int seed)
        {
            Check(low, high);
            var random = new RandomGenerator(seed);
            return () => (float)(low + (random.Next() * ((double)high - low)));
        }

        /// <summary>The sum of twelve numbers from 0 to 1 is bell-shaped with deviation 1, and needs no logarithm:
        /// those of two systems differ in the last bit.</summary>
        public static Func<float> Gaussian(float mean, float stDev, int seed)
        {
            Check(mean, stDev);
            var random = new RandomGenerator(seed);
            return () =>
            {
                var total = -6.0;
                for (var i = 0; i < 12; i++) total += random.Next();
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
            var random = new RandomGenerator(seed);
            return () =>
            {
                var at = random.Next() * length;
                var i = 0;
                while (i < bounds.Count - 2 && at > (double)bounds[i + 1] - bounds[i])
                {
                    at -= (double)bounds[i + 1] - bounds[i];
                    i += 2;
                }
                return (float)Math.Min(bounds[i] + at, bounds[i + 1]);
            };
        }

        private static void Check(params float[] numbers)
        {
            if (numbers.Any(number => float.IsNaN(number) || float.IsInfinity(number)))
                throw new UnityAgentsException("a sampler takes numbers, not NaN or infinity");
        }
    }
}
