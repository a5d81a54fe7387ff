// Application 20, which landmarks of MediaPipe's 33 belong together.
namespace NetMQExample
{
    /// <summary>The lines of a skeleton, as pairs of landmarks.</summary>
    public static class BodyLines
    {
        /// <summary>From and to.</summary>
        public static readonly (int From, int To)[] All =
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
    }
}
