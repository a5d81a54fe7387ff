// Application 20, which landmarks of a hand's 21 belong together, as MediaPipe numbers them.
namespace NetMQExample
{
    /// <summary>The lines of a hand, as pairs of landmarks.</summary>
    public static class HandLines
    {
        /// <summary>From and to.</summary>
        public static readonly (int From, int To)[] All =
        {
            // The palm, from the wrist, which is 0, around to it.
            (0, 1), (0, 5), (5, 9), (9, 13), (13, 17), (0, 17),
            // The fingers, from the thumb to the little one.
            (1, 2), (2, 3), (3, 4),
            (5, 6), (6, 7), (7, 8),
            (9, 10), (10, 11), (11, 12),
            (13, 14), (14, 15), (15, 16),
            (17, 18), (18, 19), (19, 20),
        };
    }
}
