// Lesson 09, a frame that is being written: bytes that grow, and can be written over.
using System;
using System.Text;

namespace NetMQExample
{
    /// <summary>It is used again for the next frame, and then makes no garbage.</summary>
    internal sealed class FrameBuffer
    {
        private byte[] bytes = new byte[256];

        public int Count { get; private set; }

        public void Clear() => Count = 0;

        // Forgets the bytes from a place on.
        public void Cut(int count) => Count = count;

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

        public void Write(float number) => Count += BitConverter.TryWriteBytes(GetSpan(4), number) ? 4 : 0;
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

    /// <summary>The small parts of values and rows: texts, and how many of something follow.</summary>
    internal static class MessageParts
    {
        private static readonly UTF8Encoding Utf8 = new UTF8Encoding(false, true);

        public static void WriteBytes(FrameBuffer to, byte[] bytes)
        {
            to.Write((uint)bytes.Length);
            to.Write(bytes);
        }

        public static void WriteText(FrameBuffer to, string text)
        {
            try
            {
                var size = Utf8.GetByteCount(text);
                to.Write((uint)size);
                Utf8.GetBytes(text, to.GetSpan(size));
                to.Advance(size);
            }
            catch (EncoderFallbackException e)
            {
                throw new MessageException("bad-tree", $"it is no text: {e.Message}");
            }
        }

        public static string ReadText(ref ReadOnlyMemory<byte> from) =>
            Utf8.GetString(Take(ref from, Size(ref from)).Span);

        public static int Size(ref ReadOnlyMemory<byte> from) =>
            checked((int)BitConverter.ToUInt32(Take(ref from, 4).Span));

        public static ReadOnlyMemory<byte> Take(ref ReadOnlyMemory<byte> from, int size)
        {
            var taken = from.Slice(0, size);
            from = from.Slice(size);
            return taken;
        }
    }
}
