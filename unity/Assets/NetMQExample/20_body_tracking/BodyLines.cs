// Application 20, which landmarks of a body's 33 and of a hand's 21 belong together, as MediaPipe numbers them.
namespace NetMQExample
{
    /// <summary>Lines, as pairs of landmarks.</summary>
    public static class BodyLines
    {
        public static readonly (int From, int To)[] Body =
        {
            // The face: mouth, and from ear to ear over the eyes and the nose.
            (9, 10), (8, 5), (5, 0), (0, 2), (2, 7),
            // The trunk.
            (11, 12), (11, 23), (12, 24), (23, 24),
            // Arms and hands, the left one and the right one.
            (11, 13), (13, 15), (15, 17), (15, 19), (15, 21), (17, 19),
            (12, 14), (14, 16), (16, 18), (16, 20), (16, 22), (18, 20),
            // Legs and feet.
            (23, 25), (25, 27), (27, 29), (27, 31), (29, 31),
            (24, 26), (26, 28), (28, 30), (28, 32), (30, 32),
        };

        public static readonly (int From, int To)[] Hand =
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
