// The usual ways to receive: text, bytes and whole messages; blocking, with a timeout, or what is there.
using System;
using System.Collections.Generic;
using System.Diagnostics.CodeAnalysis;
using System.Text;

namespace NetMQ
{
    /// <summary>
    /// Ways to receive. Receive… waits as long as it takes, TryReceive… only for its timeout, or not at all without
    /// one, and returns false if nothing came. Text is UTF-8 unless an encoding is given.
    /// </summary>
    public static class ReceivingSocketExtensions
    {
        private delegate T Reader<T>(ReadOnlySpan<byte> frame, Encoding encoding);

        private static readonly Reader<byte[]> asBytes = (frame, _) => frame.ToArray();
        private static readonly Reader<string> asText = (frame, encoding) => encoding.GetString(frame);
        private static readonly Reader<bool> asNothing = (_, _) => true;
        private static readonly TimeSpan forEver = SendReceiveConstants.InfiniteTimeout;
        private static readonly Encoding utf8 = SendReceiveConstants.DefaultEncoding;

        /// <summary>Receives one frame into the Msg.</summary>
        public static void Receive(this IReceivingSocket socket, ref Msg msg) => socket.TryReceive(ref msg, forEver);

        /// <summary>Receives a frame as bytes.</summary>
        public static byte[] ReceiveFrameBytes(this IReceivingSocket socket) => socket.ReceiveFrameBytes(out _);

        /// <summary>Receives a frame as bytes.</summary>
        public static byte[] ReceiveFrameBytes(this IReceivingSocket socket, out bool more)
            => Take(socket, asBytes, utf8, out more);

        /// <summary>Tries to receive a frame as bytes.</summary>
        public static bool TryReceiveFrameBytes(this IReceivingSocket socket, [NotNullWhen(true)] out byte[]? bytes)
            => TryTake(socket, TimeSpan.Zero, asBytes, utf8, out bytes, out _);

        /// <summary>Tries to receive a frame as bytes.</summary>
        public static bool TryReceiveFrameBytes(this IReceivingSocket socket, [NotNullWhen(true)] out byte[]? bytes,
            out bool more)
            => TryTake(socket, TimeSpan.Zero, asBytes, utf8, out bytes, out more);

        /// <summary>Tries to receive a frame as bytes.</summary>
        public static bool TryReceiveFrameBytes(this IReceivingSocket socket, TimeSpan timeout,
            [NotNullWhen(true)] out byte[]? bytes)
            => TryTake(socket, timeout, asBytes, utf8, out bytes, out _);

        /// <summary>Tries to receive a frame as bytes.</summary>
        public static bool TryReceiveFrameBytes(this IReceivingSocket socket, TimeSpan timeout,
            [NotNullWhen(true)] out byte[]? bytes, out bool more)
            => TryTake(socket, timeout, asBytes, utf8, out bytes, out more);

        /// <summary>Receives a frame as text.</summary>
        public static string ReceiveFrameString(this IReceivingSocket socket) => socket.ReceiveFrameString(utf8, out _);

        /// <summary>Receives a frame as text.</summary>
        public static string ReceiveFrameString(this IReceivingSocket socket, out bool more)
            => socket.ReceiveFrameString(utf8, out more);

        /// <summary>Receives a frame as text.</summary>
        public static string ReceiveFrameString(this IReceivingSocket socket, Encoding encoding)
            => socket.ReceiveFrameString(encoding, out _);

        /// <summary>Receives a frame as text.</summary>
        public static string ReceiveFrameString(this IReceivingSocket socket, Encoding encoding, out bool more)
            => Take(socket, asText, encoding, out more);

        /// <summary>Tries to receive a frame as text.</summary>
        public static bool TryReceiveFrameString(this IReceivingSocket socket,
            [NotNullWhen(true)] out string? frameString)
            => TryTake(socket, TimeSpan.Zero, asText, utf8, out frameString, out _);

        /// <summary>Tries to receive a frame as text.</summary>
        public static bool TryReceiveFrameString(this IReceivingSocket socket,
            [NotNullWhen(true)] out string? frameString, out bool more)
            => TryTake(socket, TimeSpan.Zero, asText, utf8, out frameString, out more);

        /// <summary>Tries to receive a frame as text.</summary>
        public static bool TryReceiveFrameString(this IReceivingSocket socket, Encoding encoding,
            [NotNullWhen(true)] out string? frameString)
            => TryTake(socket, TimeSpan.Zero, asText, encoding, out frameString, out _);

        /// <summary>Tries to receive a frame as text.</summary>
        public static bool TryReceiveFrameString(this IReceivingSocket socket, Encoding encoding,
            [NotNullWhen(true)] out string? frameString, out bool more)
            => TryTake(socket, TimeSpan.Zero, asText, encoding, out frameString, out more);

        /// <summary>Tries to receive a frame as text.</summary>
        public static bool TryReceiveFrameString(this IReceivingSocket socket, TimeSpan timeout,
            [NotNullWhen(true)] out string? frameString)
            => TryTake(socket, timeout, asText, utf8, out frameString, out _);

        /// <summary>Tries to receive a frame as text.</summary>
        public static bool TryReceiveFrameString(this IReceivingSocket socket, TimeSpan timeout,
            [NotNullWhen(true)] out string? frameString, out bool more)
            => TryTake(socket, timeout, asText, utf8, out frameString, out more);

        /// <summary>Tries to receive a frame as text.</summary>
        public static bool TryReceiveFrameString(this IReceivingSocket socket, TimeSpan timeout, Encoding encoding,
            [NotNullWhen(true)] out string? frameString)
            => TryTake(socket, timeout, asText, encoding, out frameString, out _);

        /// <summary>Tries to receive a frame as text.</summary>
        public static bool TryReceiveFrameString(this IReceivingSocket socket, TimeSpan timeout, Encoding encoding,
            [NotNullWhen(true)] out string? frameString, out bool more)
            => TryTake(socket, timeout, asText, encoding, out frameString, out more);

        /// <summary>Receives a message as byte frames.</summary>
        public static List<byte[]> ReceiveMultipartBytes(this IReceivingSocket socket, int expectedFrameCount = 4)
        {
            var frames = new List<byte[]>(expectedFrameCount);
            socket.ReceiveMultipartBytes(ref frames, expectedFrameCount);
            return frames;
        }

        /// <summary>Receives a message as byte frames into a list.</summary>
        public static void ReceiveMultipartBytes(this IReceivingSocket socket, [AllowNull] ref List<byte[]> frames,
            int expectedFrameCount = 4)
            => socket.TryReceiveMultipartBytes(forEver, ref frames!, expectedFrameCount);

        /// <summary>Tries to receive a message as byte frames into a list.</summary>
        public static bool TryReceiveMultipartBytes(this IReceivingSocket socket, ref List<byte[]> frames,
            int expectedFrameCount = 4)
            => socket.TryReceiveMultipartBytes(TimeSpan.Zero, ref frames, expectedFrameCount);

        /// <summary>Tries to receive a message as byte frames into a list.</summary>
        public static bool TryReceiveMultipartBytes(this IReceivingSocket socket, TimeSpan timeout,
            ref List<byte[]> frames, int expectedFrameCount = 4)
            => TryTakeAll(socket, timeout, asBytes, utf8, ref frames!, expectedFrameCount);

        /// <summary>Receives a message as text frames.</summary>
        public static List<string> ReceiveMultipartStrings(this IReceivingSocket socket, int expectedFrameCount = 4)
            => socket.ReceiveMultipartStrings(utf8, expectedFrameCount);

        /// <summary>Receives a message as text frames.</summary>
        public static List<string> ReceiveMultipartStrings(this IReceivingSocket socket, Encoding encoding,
            int expectedFrameCount = 4)
        {
            List<string>? frames = null;
            TryTakeAll(socket, forEver, asText, encoding, ref frames, expectedFrameCount);
            return frames!;
        }

        /// <summary>Tries to receive a message as text frames into a list.</summary>
        public static bool TryReceiveMultipartStrings(this IReceivingSocket socket,
            [NotNullWhen(true)] ref List<string>? frames, int expectedFrameCount = 4)
            => TryTakeAll(socket, TimeSpan.Zero, asText, utf8, ref frames, expectedFrameCount);

        /// <summary>Tries to receive a message as text frames into a list.</summary>
        public static bool TryReceiveMultipartStrings(this IReceivingSocket socket, Encoding encoding,
            [NotNullWhen(true)] ref List<string>? frames, int expectedFrameCount = 4)
            => TryTakeAll(socket, TimeSpan.Zero, asText, encoding, ref frames, expectedFrameCount);

        /// <summary>Tries to receive a message as text frames into a list.</summary>
        public static bool TryReceiveMultipartStrings(this IReceivingSocket socket, TimeSpan timeout,
            [NotNullWhen(true)] ref List<string>? frames, int expectedFrameCount = 4)
            => TryTakeAll(socket, timeout, asText, utf8, ref frames, expectedFrameCount);

        /// <summary>Tries to receive a message as text frames into a list.</summary>
        public static bool TryReceiveMultipartStrings(this IReceivingSocket socket, TimeSpan timeout, Encoding encoding,
            [NotNullWhen(true)] ref List<string>? frames, int expectedFrameCount = 4)
            => TryTakeAll(socket, timeout, asText, encoding, ref frames, expectedFrameCount);

        /// <summary>Receives a message.</summary>
        public static NetMQMessage ReceiveMultipartMessage(this IReceivingSocket socket, int expectedFrameCount = 4)
        {
            NetMQMessage? message = null;
            socket.TryReceiveMultipartMessage(forEver, ref message, expectedFrameCount);
            return message!;
        }

        /// <summary>Tries to receive a message.</summary>
        public static bool TryReceiveMultipartMessage(this IReceivingSocket socket,
            [NotNullWhen(true)] ref NetMQMessage? message, int expectedFrameCount = 4)
            => socket.TryReceiveMultipartMessage(TimeSpan.Zero, ref message, expectedFrameCount);

        /// <summary>Tries to receive a message.</summary>
        public static bool TryReceiveMultipartMessage(this IReceivingSocket socket, TimeSpan timeout,
            [NotNullWhen(true)] ref NetMQMessage? message, int expectedFrameCount = 4)
        {
            if (!TryTake(socket, timeout, asBytes, utf8, out var frame, out var more)) return false;
            if (message == null) message = new NetMQMessage(expectedFrameCount);
            else message.Clear();
            message.Append(frame!);
            while (more) message.Append(Take(socket, asBytes, utf8, out more));
            return true;
        }

        /// <summary>Receives a frame and forgets it.</summary>
        public static void SkipFrame(this IReceivingSocket socket) => socket.SkipFrame(out _);

        /// <summary>Receives a frame and forgets it.</summary>
        public static void SkipFrame(this IReceivingSocket socket, out bool more)
            => Take(socket, asNothing, utf8, out more);

        /// <summary>Tries to receive a frame, and forgets it.</summary>
        public static bool TrySkipFrame(this IReceivingSocket socket) => socket.TrySkipFrame(TimeSpan.Zero, out _);

        /// <summary>Tries to receive a frame, and forgets it.</summary>
        public static bool TrySkipFrame(this IReceivingSocket socket, out bool more)
            => socket.TrySkipFrame(TimeSpan.Zero, out more);

        /// <summary>Tries to receive a frame, and forgets it.</summary>
        public static bool TrySkipFrame(this IReceivingSocket socket, TimeSpan timeout)
            => socket.TrySkipFrame(timeout, out _);

        /// <summary>Tries to receive a frame, and forgets it.</summary>
        public static bool TrySkipFrame(this IReceivingSocket socket, TimeSpan timeout, out bool more)
            => TryTake(socket, timeout, asNothing, utf8, out _, out more);

        /// <summary>Receives a message and forgets it.</summary>
        public static void SkipMultipartMessage(this IReceivingSocket socket)
            => socket.TrySkipMultipartMessage(forEver);

        /// <summary>Tries to receive a frame, and forgets it: NetMQ skips no further than the first one here.</summary>
        public static bool TrySkipMultipartMessage(this IReceivingSocket socket) => socket.TrySkipFrame();

        /// <summary>Tries to receive a message, and forgets it.</summary>
        public static bool TrySkipMultipartMessage(this IReceivingSocket socket, TimeSpan timeout)
        {
            if (!socket.TrySkipFrame(timeout, out var more)) return false;
            while (more) socket.SkipFrame(out more);
            return true;
        }

        private static T Take<T>(IReceivingSocket socket, Reader<T> read, Encoding encoding, out bool more)
        {
            TryTake(socket, forEver, read, encoding, out var result, out more);
            return result!;
        }

        private static bool TryTakeAll<T>(IReceivingSocket socket, TimeSpan timeout, Reader<T> read, Encoding encoding,
            ref List<T>? frames, int expectedFrameCount)
        {
            if (!TryTake(socket, timeout, read, encoding, out var frame, out var more)) return false;
            if (frames == null) frames = new List<T>(expectedFrameCount);
            else frames.Clear();
            frames.Add(frame!);
            while (more) frames.Add(Take(socket, read, encoding, out more));
            return true;
        }

        private static bool TryTake<T>(IReceivingSocket socket, TimeSpan timeout, Reader<T> read, Encoding encoding,
            [MaybeNull] out T result, out bool more)
        {
            result = default;
            more = false;
            if (socket is NetMQSocket own)
            {
                // Read where libzmq put it, without a Msg in between.
                own.Enter();
                try
                {
                    if (!own.TryReceiveFrame(timeout)) return false;
                    more = own.FrameHasMore;
                    result = read(own.Frame, encoding);
                    own.DropFrame();
                    return true;
                }
                finally
                {
                    own.Leave();
                }
            }
            var msg = new Msg();
            msg.InitEmpty();
            var received = socket.TryReceive(ref msg, timeout);
            if (received)
            {
                more = msg.HasMore;
                result = read(msg.Slice(), encoding);
            }
            msg.Close();
            return received;
        }
    }
}
