// Where the bytes of a Msg come from, and where they go back to.
using System;
using System.Threading;

namespace NetMQ
{
    /// <summary>Lends buffers.</summary>
    public interface IBufferPool : IDisposable
    {
        /// <summary>A buffer of at least this size.</summary>
        byte[] Take(int size);

        /// <summary>Takes a buffer back.</summary>
        void Return(byte[] buffer);
    }

    /// <summary>No pool: each buffer is new, and the garbage collector takes it back.</summary>
    public class GCBufferPool : IBufferPool
    {
        /// <inheritdoc/>
        public byte[] Take(int size) => new byte[size];

        /// <inheritdoc/>
        public void Return(byte[] buffer) { }

        /// <inheritdoc/>
        public void Dispose()
        {
            Dispose(true);
            GC.SuppressFinalize(this);
        }

        /// <summary>Nothing to free.</summary>
        protected virtual void Dispose(bool disposing) { }
    }

    /// <summary>The pool of the whole process; at first a <see cref="GCBufferPool"/>.</summary>
    public static class BufferPool
    {
        private static IBufferPool pool = new GCBufferPool();

        /// <summary>Goes back to the garbage collector.</summary>
        public static void SetGCBufferPool() => SetCustomBufferPool(new GCBufferPool());

        /// <summary>Uses another pool and disposes the one before.</summary>
        public static void SetCustomBufferPool(IBufferPool bufferPool)
            => Interlocked.Exchange(ref pool, bufferPool)?.Dispose();

        /// <summary>A buffer of at least this size.</summary>
        public static byte[] Take(int size) => pool.Take(size);

        /// <summary>Takes a buffer back.</summary>
        public static void Return(byte[] buffer) => pool.Return(buffer);
    }
}
