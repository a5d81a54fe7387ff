// Lesson 09, the small parts of values and rows: texts, and how many of something follow.
using System;
using System.Text;

namespace NetMQExample
{
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
