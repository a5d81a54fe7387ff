// One frame of a NetMQMessage.
using System;
using System.Buffers.Binary;
using System.Text;

namespace NetMQ
{
    /// <summary>The bytes of one frame. Text is ASCII unless an encoding is given.</summary>
    public class NetMQFrame : IEquatable<NetMQFrame>, IEquatable<byte[]>
    {
        private int messageSize;
        private int hash;

        /// <summary>All bytes of an array, which is not copied.</summary>
        public NetMQFrame(byte[]? buffer)
        {
            Buffer = buffer ?? Array.Empty<byte>();
            MessageSize = Buffer.Length;
        }

        /// <summary>The first bytes of an array, which is not copied.</summary>
        public NetMQFrame(byte[] buffer, int length)
        {
            Buffer = buffer ?? throw new ArgumentNullException(nameof(buffer));
            if (length > buffer.Length)
            {
                throw new ArgumentOutOfRangeException(nameof(length), length,
                    "Must be less than or equal to the provided buffer's length.");
            }
            MessageSize = length;
        }

        /// <summary>Text in ASCII: what is not ASCII becomes a question mark.</summary>
        public NetMQFrame(string message) : this(message, Encoding.ASCII) { }

        /// <summary>Text.</summary>
        public NetMQFrame(string message, Encoding encoding) : this(encoding.GetBytes(message)) { }

        /// <summary>Zero bytes, to be filled.</summary>
        public NetMQFrame(int length)
        {
            if (length < 0) throw new ArgumentOutOfRangeException(nameof(length), "A non-negative value is expected.");
            Buffer = new byte[length];
            MessageSize = length;
        }

        /// <summary>A frame without content.</summary>
        public static NetMQFrame Empty => new NetMQFrame(0);

        /// <summary>The array.</summary>
        public byte[] Buffer { get; }

        /// <summary>The size of the array.</summary>
        public int BufferSize => Buffer.Length;

        /// <summary>How much of the array belongs to the frame.</summary>
        public int MessageSize
        {
            get => messageSize;
            set
            {
                if (value < 0 || value > BufferSize)
                {
                    throw new ArgumentOutOfRangeException(nameof(value),
                        "Expecting a non-negative value less than or equal to the buffer size.");
                }
                messageSize = value;
            }
        }

        /// <summary>True if there is no content.</summary>
        public bool IsEmpty => MessageSize == 0;

        /// <summary>True if both have the same content.</summary>
        public static bool operator ==(NetMQFrame? one, NetMQFrame? other) => one?.Equals(other) ?? other is null;

        /// <summary>True if the content differs.</summary>
        public static bool operator !=(NetMQFrame? one, NetMQFrame? other) => !(one == other);

        /// <summary>A frame with a copy of the bytes.</summary>
        public static NetMQFrame Copy(byte[] buffer)
            => new NetMQFrame((byte[])(buffer ?? throw new ArgumentNullException(nameof(buffer))).Clone());

        /// <summary>A copy with an array of its own.</summary>
        public static NetMQFrame Copy(NetMQFrame frame)
            => (frame ?? throw new ArgumentNullException(nameof(frame))).Duplicate();

        /// <summary>A copy with an array of its own.</summary>
        public NetMQFrame Duplicate() => new NetMQFrame((byte[])Buffer.Clone(), MessageSize);

        /// <summary>The content as ASCII text.</summary>
        public string ConvertToString() => ConvertToString(Encoding.ASCII);

        /// <summary>The content as text.</summary>
        public string ConvertToString(Encoding encoding) => encoding.GetString(Buffer, 0, MessageSize);

        /// <summary>The first four bytes as a number, the highest byte first.</summary>
        public int ConvertToInt32() => BinaryPrimitives.ReadInt32BigEndian(Buffer);

        /// <summary>The first eight bytes as a number, the highest byte first.</summary>
        public long ConvertToInt64() => BinaryPrimitives.ReadInt64BigEndian(Buffer);

        /// <summary>
        /// The array itself, or with <paramref name="copy"/> a copy of the content if the array is larger.
        /// </summary>
        public byte[] ToByteArray(bool copy = false) => copy && MessageSize != BufferSize ? AsSpan().ToArray() : Buffer;

        /// <summary>The content.</summary>
        public ReadOnlySpan<byte> AsSpan() => new ReadOnlySpan<byte>(Buffer, 0, MessageSize);

        /// <summary>True if both have the same content.</summary>
        public bool Equals(byte[]? other) => other != null && AsSpan().SequenceEqual(other);

        /// <summary>True if both have the same content.</summary>
        public bool Equals(NetMQFrame? other) => !(other is null) && AsSpan().SequenceEqual(other.AsSpan());

        /// <inheritdoc/>
        public override bool Equals(object? obj) => Equals(obj as NetMQFrame);

        /// <inheritdoc/>
        public override int GetHashCode()
        {
            if (hash == 0)
            {
                foreach (var b in Buffer) hash = (31 * hash) ^ b;
            }
            return hash;
        }
    }
}
