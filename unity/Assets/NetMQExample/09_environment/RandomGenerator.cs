// Lesson 09, chance: random numbers that are the same in every language.
namespace NetMQExample
{
    /// <summary>SplitMix64 (Steele, Lea and Flood, 2014).</summary>
    public sealed class RandomGenerator
    {
        private ulong seed;

        /// <summary>The same seed gives the same numbers.</summary>
        public RandomGenerator(long seed) => this.seed = (ulong)seed;

        /// <summary>The next number, from 0 to 1.</summary>
        public double Next()
        {
            unchecked
            {
                seed += 0x9E3779B97F4A7C15;
                var bits = (seed ^ seed >> 30) * 0xBF58476D1CE4E5B9;
                bits = (bits ^ bits >> 27) * 0x94D049BB133111EB;
                return ((bits ^ bits >> 31) >> 11) / 9007199254740992.0;
            }
        }
    }
}
