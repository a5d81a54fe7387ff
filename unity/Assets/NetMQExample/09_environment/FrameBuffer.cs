// Lesson 09, a frame that is being written: bytes that grow, and can be written over.
using System;

namespace NetMQExample
{
    /// <summary>It is used again for the next frame, and then makes no garbage.</summary>
    internal sealed class FrameBuffer
    {
        private byte[] bytes = new byte[256];

        public int Count { get; private set; }

        public void Clear() => Count = 0;

        public void Advance(int count) => Count += count;

        public Span<byte> GetSpan(int size)
        {
            Grow(size);
            return bytes.AsSpan(Count);
        }

        // The bytes from a place on: to be written over, or to be sent.
        public Span<byte> At(int at) => bytes.AsSpan(at, Count - at);

        public ReadOnlyMemory<byte> From(int at) => bytes.AsMemory(at, Count - at);

        // Zeros, to be written over, behind zeros up to a multiple of 8; and where they begin.
        public int Reserve(int size)
        {
            Pad();
            var at = Count;
            GetSpan(size).Slice(0, size).Clear();
            Count += size;
            return at;
        }

        public void Pad()
        {
            for (Grow(8); Count % 8 != 0; Count++) bytes[Count] = 0;
        }

        // All machines that Unity runs on are little-endian, as the bytes are.
        public void Write(uint number) => Count += BitConverter.TryWriteBytes(GetSpan(4), number) ? 4 : 0;

        public void Write(long number) => Count += BitConverter.TryWriteBytes(GetSpan(8), number) ? 8 : 0;

        public void Write(double number) => Count += BitConverter.TryWriteBytes(GetSpan(8), number) ? 8 : 0;

        public void Write(byte number)
        {
            Grow(1);
            bytes[Count++] = number;
        }

        public void Write(ReadOnlySpan<byte> from)
        {
            Grow(from.Length);
            from.CopyTo(bytes.AsSpan(Count));
            Count += from.Length;
        }

        private void Grow(int by)
        {
            if (bytes.Length - Count >= by) return;
            // In long: twice as much may be more than an int.
            Array.Resize(ref bytes, (int)Math.Min(int.MaxValue - 64, Math.Max(2L * bytes.Length, (long)Count + by)));
        }
    }
}
