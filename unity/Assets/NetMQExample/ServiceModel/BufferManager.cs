// NetMQ.dll names this class in a part that nobody here uses, BufferPool.SetBufferManagerBufferPool, and Unity has no library
// with it. IL2CPP's linker wants every name that it meets to be found: so here it is, in an assembly of that library's
// name. Where the package org.nuget.system.servicemodel.primitives brings the real one, this is left out (its .asmdef).
[assembly: System.Reflection.AssemblyVersion("8.1.2.0")]

namespace System.ServiceModel.Channels
{
    /// <summary>As the real one declares it, as far as NetMQ names it.</summary>
    public abstract class BufferManager
    {
        /// <summary>Makes a pool: here there is none.</summary>
        /// <param name="maxBufferPoolSize">Not used.</param>
        /// <param name="maxBufferSize">Not used.</param>
        /// <returns>Nothing.</returns>
        public static BufferManager CreateBufferManager(long maxBufferPoolSize, int maxBufferSize) =>
            throw new NotSupportedException("Unity has no System.ServiceModel.Primitives: leave out SetBufferManagerBufferPool");

        /// <summary>Takes a buffer.</summary>
        /// <param name="bufferSize">Its size.</param>
        /// <returns>The buffer.</returns>
        public abstract byte[] TakeBuffer(int bufferSize);

        /// <summary>Gives a buffer back.</summary>
        /// <param name="buffer">The buffer.</param>
        public abstract void ReturnBuffer(byte[] buffer);

        /// <summary>Forgets the buffers.</summary>
        public abstract void Clear();
    }
}
