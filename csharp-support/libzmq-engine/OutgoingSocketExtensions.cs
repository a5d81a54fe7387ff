// The usual ways to send: text, bytes, empty frames and whole messages; blocking, with a timeout, or at once.
using System;
using System.Buffers;
using System.Collections.Generic;
using System.Text;

namespace NetMQ
{
    /// <summary>
    /// Ways to send. Send… waits as long as it takes, TrySend… only for its timeout, or not at all without one, and
    /// returns false if that was too short.
    /// </summary>
    public static class OutgoingSocketExtensions
    {
        private static readonly TimeSpan forEver = SendReceiveConstants.InfiniteTimeout;

        /// <summary>Sends one frame and leaves the Msg empty.</summary>
        public static void Send(this IOutgoingSocket socket, ref Msg msg, bool more)
            => socket.TrySend(ref msg, forEver, more);

        /// <summary>Sends a frame of bytes.</summary>
        public static void SendFrame(this IOutgoingSocket socket, byte[] data, bool more = false)
            => TrySend(socket, forEver, data.AsSpan(0, data.Length), more);

        /// <summary>Sends a frame of the first bytes.</summary>
        public static void SendFrame(this IOutgoingSocket socket, byte[] data, int length, bool more = false)
            => TrySend(socket, forEver, data.AsSpan(0, length), more);

        /// <summary>Sends a frame of UTF-8 text.</summary>
        public static void SendFrame(this IOutgoingSocket socket, string message, bool more = false)
            => TrySend(socket, forEver, message, more);

        /// <summary>Sends a frame without content.</summary>
        public static void SendFrameEmpty(this IOutgoingSocket socket, bool more = false)
            => TrySend(socket, forEver, default(ReadOnlySpan<byte>), more);

        /// <summary>Sends a frame of bytes that others follow.</summary>
        public static IOutgoingSocket SendMoreFrame(this IOutgoingSocket socket, byte[] data)
        {
            socket.SendFrame(data, true);
            return socket;
        }

        /// <summary>Sends a frame of the first bytes that others follow.</summary>
        public static IOutgoingSocket SendMoreFrame(this IOutgoingSocket socket, byte[] data, int length)
        {
            socket.SendFrame(data, length, true);
            return socket;
        }

        /// <summary>Sends a frame of UTF-8 text that others follow.</summary>
        public static IOutgoingSocket SendMoreFrame(this IOutgoingSocket socket, string message)
        {
            socket.SendFrame(message, true);
            return socket;
        }

        /// <summary>Sends a frame without content that others follow.</summary>
        public static IOutgoingSocket SendMoreFrameEmpty(this IOutgoingSocket socket)
        {
            socket.SendFrameEmpty(true);
            return socket;
        }

        /// <summary>Tries to send a frame of the first bytes.</summary>
        public static bool TrySendFrame(this IOutgoingSocket socket, TimeSpan timeout, byte[] data, int length,
            bool more = false)
            => TrySend(socket, timeout, data.AsSpan(0, length), more);

        /// <summary>Tries to send a frame of bytes.</summary>
        public static bool TrySendFrame(this IOutgoingSocket socket, TimeSpan timeout, byte[] data, bool more = false)
            => TrySend(socket, timeout, data.AsSpan(0, data.Length), more);

        /// <summary>Tries to send a frame of bytes.</summary>
        public static bool TrySendFrame(this IOutgoingSocket socket, byte[] data, bool more = false)
            => TrySend(socket, TimeSpan.Zero, data.AsSpan(0, data.Length), more);

        /// <summary>Tries to send a frame of the first bytes.</summary>
        public static bool TrySendFrame(this IOutgoingSocket socket, byte[] data, int length, bool more = false)
            => TrySend(socket, TimeSpan.Zero, data.AsSpan(0, length), more);

        /// <summary>Tries to send a frame of UTF-8 text.</summary>
        public static bool TrySendFrame(this IOutgoingSocket socket, TimeSpan timeout, string message,
            bool more = false)
            => TrySend(socket, timeout, message, more);

        /// <summary>Tries to send a frame of UTF-8 text.</summary>
        public static bool TrySendFrame(this IOutgoingSocket socket, string message, bool more = false)
            => TrySend(socket, TimeSpan.Zero, message, more);

        /// <summary>Tries to send a frame without content.</summary>
        public static bool TrySendFrameEmpty(this IOutgoingSocket socket, TimeSpan timeout, bool more = false)
            => TrySend(socket, timeout, default(ReadOnlySpan<byte>), more);

        /// <summary>Tries to send a frame without content.</summary>
        public static bool TrySendFrameEmpty(this IOutgoingSocket socket, bool more = false)
            => TrySend(socket, TimeSpan.Zero, default(ReadOnlySpan<byte>), more);

        /// <summary>Sends a message.</summary>
        public static void SendMultipartMessage(this IOutgoingSocket socket, NetMQMessage message)
            => socket.TrySendMultipartMessage(forEver, message);

        /// <summary>Tries to send a message.</summary>
        public static bool TrySendMultipartMessage(this IOutgoingSocket socket, NetMQMessage message)
            => socket.TrySendMultipartMessage(TimeSpan.Zero, message);

        /// <summary>Tries to send a message.</summary>
        public static bool TrySendMultipartMessage(this IOutgoingSocket socket, TimeSpan timeout, NetMQMessage message)
        {
            if (message.FrameCount == 0) throw new ArgumentException("message is empty", nameof(message));
            for (var i = 0; i < message.FrameCount; i++)
            {
                // A message is sent whole or not at all, so after its first frame nothing can be missed.
                var sent = TrySend(socket, i == 0 ? timeout : forEver, message[i].AsSpan(), i < message.FrameCount - 1);
                if (!sent) return false;
            }
            return true;
        }

        /// <summary>Sends a message of byte frames.</summary>
        public static void SendMultipartBytes(this IOutgoingSocket socket, params byte[][] frames)
            => socket.TrySendMultipartBytes(forEver, (IEnumerable<byte[]>)frames);

        /// <summary>Sends a message of byte frames.</summary>
        public static void SendMultipartBytes(this IOutgoingSocket socket, IEnumerable<byte[]> frames)
            => socket.TrySendMultipartBytes(forEver, frames);

        /// <summary>Tries to send a message of byte frames.</summary>
        public static bool TrySendMultipartBytes(this IOutgoingSocket socket, params byte[][] frames)
            => socket.TrySendMultipartBytes(TimeSpan.Zero, (IEnumerable<byte[]>)frames);

        /// <summary>Tries to send a message of byte frames.</summary>
        public static bool TrySendMultipartBytes(this IOutgoingSocket socket, IEnumerable<byte[]> frames)
            => socket.TrySendMultipartBytes(TimeSpan.Zero, frames);

        /// <summary>Tries to send a message of byte frames.</summary>
        public static bool TrySendMultipartBytes(this IOutgoingSocket socket, TimeSpan timeout, params byte[][] frames)
            => socket.TrySendMultipartBytes(timeout, (IEnumerable<byte[]>)frames);

        /// <summary>Tries to send a message of byte frames.</summary>
        public static bool TrySendMultipartBytes(this IOutgoingSocket socket, TimeSpan timeout,
            IEnumerable<byte[]> frames)
        {
            using var frame = frames.GetEnumerator();
            if (!frame.MoveNext()) throw new ArgumentException("frames is empty", nameof(frames));
            var more = true;
            for (var wait = timeout; more; wait = forEver)
            {
                var data = frame.Current;
                more = frame.MoveNext();
                if (!TrySend(socket, wait, data, more)) return false;
            }
            return true;
        }

        private static bool TrySend(IOutgoingSocket socket, TimeSpan timeout, string message, bool more)
        {
            var encoding = SendReceiveConstants.DefaultEncoding;
            var size = encoding.GetByteCount(message);
            if (size <= 512)
            {
                Span<byte> small = stackalloc byte[512];
                return TrySend(socket, timeout, small.Slice(0, encoding.GetBytes(message, small)), more);
            }
            var large = ArrayPool<byte>.Shared.Rent(size);
            try
            {
                return TrySend(socket, timeout, large.AsSpan(0, encoding.GetBytes(message, large)), more);
            }
            finally
            {
                ArrayPool<byte>.Shared.Return(large);
            }
        }

        private static bool TrySend(IOutgoingSocket socket, TimeSpan timeout, ReadOnlySpan<byte> data, bool more)
        {
            // libzmq copies the bytes, so one of our own sockets needs no Msg in between.
            if (socket is NetMQSocket own) return own.TrySendBytes(data, timeout, more);
            var msg = new Msg();
            msg.InitPool(data.Length);
            data.CopyTo(msg.Slice());
            var sent = socket.TrySend(ref msg, timeout, more);
            msg.Close();
            return sent;
        }
    }
}
