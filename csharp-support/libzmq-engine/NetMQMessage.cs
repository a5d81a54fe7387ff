// A whole message: a list of frames.
using System;
using System.Buffers.Binary;
using System.Collections;
using System.Collections.Generic;
using System.Linq;
using System.Text;

namespace NetMQ
{
    /// <summary>
    /// The frames of one message. Append adds at the end, Push at the beginning; text is ASCII unless an encoding is
    /// given.
    /// </summary>
    public class NetMQMessage : IEnumerable<NetMQFrame>
    {
        private readonly List<NetMQFrame> frames;

        /// <summary>No frames yet.</summary>
        public NetMQMessage(int expectedFrameCount = 4) => frames = new List<NetMQFrame>(expectedFrameCount);

        /// <summary>The given frames.</summary>
        public NetMQMessage(IEnumerable<NetMQFrame> frames)
            => this.frames = new List<NetMQFrame>(frames ?? throw new ArgumentNullException(nameof(frames)));

        /// <summary>One frame for each array.</summary>
        public NetMQMessage(IEnumerable<byte[]> buffers)
            : this((buffers ?? throw new ArgumentNullException(nameof(buffers))).Select(b => new NetMQFrame(b))) { }

        /// <summary>The first frame.</summary>
        public NetMQFrame First => frames[0];

        /// <summary>The last frame.</summary>
        public NetMQFrame Last => frames[frames.Count - 1];

        /// <summary>True if there are no frames.</summary>
        public bool IsEmpty => frames.Count == 0;

        /// <summary>The number of frames.</summary>
        public int FrameCount => frames.Count;

        /// <summary>One frame.</summary>
        public NetMQFrame this[int index] => frames[index];

        /// <summary>Adds a frame at the end.</summary>
        public void Append(NetMQFrame frame) => frames.Add(frame);

        /// <summary>Adds bytes at the end.</summary>
        public void Append(byte[] buffer) => Append(new NetMQFrame(buffer));

        /// <summary>Adds ASCII text at the end.</summary>
        public void Append(string message) => Append(new NetMQFrame(message));

        /// <summary>Adds text at the end.</summary>
        public void Append(string message, Encoding encoding) => Append(new NetMQFrame(message, encoding));

        /// <summary>Adds four bytes at the end, the highest first.</summary>
        public void Append(int value) => Append(Bytes(value));

        /// <summary>Adds eight bytes at the end, the highest first.</summary>
        public void Append(long value) => Append(Bytes(value));

        /// <summary>Adds a frame without content at the end.</summary>
        public void AppendEmptyFrame() => Append(NetMQFrame.Empty);

        /// <summary>Adds a frame at the beginning.</summary>
        public void Push(NetMQFrame frame) => frames.Insert(0, frame);

        /// <summary>Adds bytes at the beginning.</summary>
        public void Push(byte[] buffer) => Push(new NetMQFrame(buffer));

        /// <summary>Adds ASCII text at the beginning.</summary>
        public void Push(string message) => Push(new NetMQFrame(message));

        /// <summary>Adds text at the beginning.</summary>
        public void Push(string message, Encoding encoding) => Push(new NetMQFrame(message, encoding));

        /// <summary>Adds four bytes at the beginning, the highest first.</summary>
        public void Push(int value) => Push(Bytes(value));

        /// <summary>Adds eight bytes at the beginning, the highest first.</summary>
        public void Push(long value) => Push(Bytes(value));

        /// <summary>Adds a frame without content at the beginning.</summary>
        public void PushEmptyFrame() => Push(NetMQFrame.Empty);

        /// <summary>Removes the first frame and returns it.</summary>
        public NetMQFrame Pop()
        {
            var frame = frames[0];
            frames.RemoveAt(0);
            return frame;
        }

        /// <summary>Removes the first frame that has the same content.</summary>
        public bool RemoveFrame(NetMQFrame frame) => frames.Remove(frame);

        /// <summary>Removes all frames.</summary>
        public void Clear() => frames.Clear();

        /// <inheritdoc/>
        public IEnumerator<NetMQFrame> GetEnumerator() => frames.GetEnumerator();

        IEnumerator IEnumerable.GetEnumerator() => GetEnumerator();

        /// <inheritdoc/>
        public override string ToString()
            => IsEmpty ? "NetMQMessage[<no frames>]"
                : $"NetMQMessage[{string.Join(",", frames.Select(f => f.ConvertToString()))}]";

        private static byte[] Bytes(int value)
        {
            var bytes = new byte[sizeof(int)];
            BinaryPrimitives.WriteInt32BigEndian(bytes, value);
            return bytes;
        }

        private static byte[] Bytes(long value)
        {
            var bytes = new byte[sizeof(long)];
            BinaryPrimitives.WriteInt64BigEndian(bytes, value);
            return bytes;
        }
    }
}
