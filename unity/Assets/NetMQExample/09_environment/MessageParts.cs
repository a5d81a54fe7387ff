// Lesson 09, the small parts of values and rows: texts, and how many of something follow.
using System;
using System.Buffers;
using System.Text;

namespace NetMQExample
{
    internal static class MessageParts
    {
        private static readonly UTF8Encoding Utf8 = new UTF8Encoding(false, true);

        /// <summary>Numbers without a sign, as many as bytes can be: how many items follow.</summary>
        public static void WriteSize(IBufferWriter<byte> to, int size)
        {
            BitConverter.TryWriteBytes(to.GetSpan(4), (uint)size);
            to.Advance(4);
        }

        public static void WriteBytes(IBufferWriter<byte> to, byte[] bytes)
        {
            WriteSize(to, bytes.Length);
            to.Write(bytes);
        }

        public static void WriteText(IBufferWriter<byte> to, string text)
        {
            try
            {
                var size = Utf8.GetByteCount(text);
                WriteSize(to, size);
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
