// The one call of NetMQ's own dependency AsyncIO that programs make.
namespace AsyncIO
{
    /// <summary>
    /// On Windows, NetMQ chooses between two kinds of sockets with it. libzmq has one kind: nothing to choose.
    /// </summary>
    public static class ForceDotNet
    {
        /// <summary>Does nothing here.</summary>
        public static void Force() { }

        /// <summary>Does nothing here.</summary>
        public static void Unforce() { }
    }
}
