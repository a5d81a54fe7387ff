// Lesson 13, messages: the values in one message of a side channel, as ML-Agents lays them out.
//
// Values stand one after the other, little-endian, without a name, a type or a gap: whoever reads has to know the
// order. A value that is not there at all, because the message is over, is the default.
// Bytes: bool 1; int32 and float32 4; a string its length as int32, then its ASCII; a list its count as int32, then its
// float32s. In Python: incoming_message.py, outgoing_message.py.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Text;

namespace NetMQExample.MLAgents.SideChannels
{
    /// <summary>Read its values in the order in which they were written.</summary>
    public sealed class IncomingMessage : IDisposable
    {
        // Both halves of ML-Agents make zeros of a list's items that are missing. More than so many would only fill the
        // memory.
        private const int MostMissingItems = 65536;

        private readonly byte[] buffer;
        private int offset;

        public IncomingMessage(byte[] buffer, int offset = 0) =>
            (this.buffer, this.offset) = (Require.Given("buffer", buffer), offset);

        // ASCII, or what WriteString wrote with utf8: true. Half a character cannot be written; a question mark can.
        internal static Encoding Utf8 { get; } =
            Encoding.GetEncoding("utf-8", new EncoderReplacementFallback("?"), new DecoderExceptionFallback());

        private int Left => buffer.Length - offset;

        /// <summary>One byte; all but 0 is true.</summary>
        public bool ReadBoolean(bool defaultValue = false) => Left <= 0 ? defaultValue : buffer[Advance(1)] != 0;

        /// <summary>Four bytes.</summary>
        public int ReadInt32(int defaultValue = 0) =>
            Left <= 0 ? defaultValue : BitConverter.ToInt32(buffer, Advance(4));

        /// <summary>Four bytes.</summary>
        public float ReadFloat32(float defaultValue = 0) =>
            Left <= 0 ? defaultValue : BitConverter.ToSingle(buffer, Advance(4));

        /// <summary>Its length, and so many bytes, or those that are left.</summary>
        public string ReadString(string defaultValue = default)
        {
            if (Left <= 0) return defaultValue;
            var length = Math.Min(ReadLength(), Left);
            try { return Utf8.GetString(buffer, Advance(length), length); }
            catch (ArgumentException) { throw new UnityAgentsException("a text that is neither ASCII nor UTF-8"); }
        }

        /// <summary>Its count, and so many numbers; those that are missing are 0.</summary>
        public IList<float> ReadFloatList(IList<float> defaultValue = default)
        {
            if (Left <= 0) return defaultValue;
            var count = ReadLength();
            if (count - (Left / 4) > MostMissingItems)
                throw new UnityAgentsException($"a list of {count} items, of which {Left} bytes are there");
            var list = new float[count];
            for (var i = 0; i < count; i++) list[i] = ReadFloat32();
            return list;
        }

        /// <summary>The whole message, however much of it was read.</summary>
        public byte[] GetRawBytes() => buffer;

        /// <summary>Nothing has to be done, and a using statement is as welcome as in ML-Agents.</summary>
        public void Dispose() { }

        private int ReadLength()
        {
            var length = ReadInt32();
            return length >= 0 ? length : throw new UnityAgentsException($"a length of {length}");
        }

        private int Advance(int size)
        {
            if (Left < size) throw new UnityAgentsException($"a number of which only {Left} bytes are there");
            var before = offset;
            offset += size;
            return before;
        }
    }

    /// <summary>Write its values in the order in which they will be read.</summary>
    public sealed class OutgoingMessage : IDisposable
    {
        private readonly MemoryStream stream = new MemoryStream();
        private readonly BinaryWriter writer;

        public OutgoingMessage() => writer = new BinaryWriter(stream);

        /// <summary>One byte.</summary>
        public void WriteBoolean(bool b) => writer.Write(b);

        /// <summary>Four bytes.</summary>
        public void WriteInt32(int i) => writer.Write(i);

        /// <summary>Four bytes.</summary>
        public void WriteFloat32(float f) => writer.Write(f);

        /// <summary>Its length, and its characters: ASCII, unless the other side is of this kit. With other ones the
        /// message is not sent, and SideChannelManager.Report gets a line.</summary>
        public void WriteString(string str, bool utf8 = false)
        {
            // Not the bytes: of half a character they are a question mark.
            if (!utf8 && str.Any(one => one > 127))
                Refused = "text that is not ASCII: write it with utf8: true";
            var data = IncomingMessage.Utf8.GetBytes(str);
            writer.Write(data.Length);
            writer.Write(data);
        }

        /// <summary>Its count, and its numbers.</summary>
        public void WriteFloatList(IList<float> floatList)
        {
            writer.Write(floatList.Count);
            foreach (var one in floatList) writer.Write(one);
        }

        /// <summary>The whole message, in place of what was written.</summary>
        public void SetRawBytes(byte[] data)
        {
            Refused = null;
            stream.SetLength(0);
            writer.Write(data);
        }

        public void Dispose() => writer.Dispose();

        // Why it will not be sent.
        internal string Refused { get; private set; }

        internal byte[] ToByteArray() => stream.ToArray();
    }
}
