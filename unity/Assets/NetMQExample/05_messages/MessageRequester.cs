// Lesson 05, messages: ask with structure and pixels, and let the large buffers be used again.
//
// Take home: this file, Message.cs and Json.cs beside it, NetMQConnection.cs and NetMQLifetime.cs. The Python side is
// python/05_messages/server.py. Bytes: see Message.cs.
// Trouble: the console twin sends a wrong message first with --wrong json, version, kind, shape or frames.
// Why the pool: SendFrame(bytes) and ReceiveFrameBytes() make three new arrays of a picture's size for each echo. Arrays
// over 85,000 bytes are collected only by the slowest of .NET's collections; the twin's --measure shows what that costs.
using System;
using System.Buffers;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using System.Text;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample
{
    /// <summary>
    /// Asks a REP server with messages. Make it, use it and dispose it on one thread, and not on Unity's main thread: a
    /// request blocks until its reply is there.
    /// </summary>
    public sealed class MessageRequester : IDisposable
    {
        private readonly NetMQConnection connection;
        private readonly string endpoint;
        // The frames of the last reply. A Msg gives its buffer back to the pool when it receives the next frame.
        private readonly List<ReadOnlyMemory<byte>> frames = new List<ReadOnlyMemory<byte>>();
        private Msg[] parts = new Msg[0];

        static MessageRequester() => PooledBuffers.Use();

        /// <summary>Connects, which succeeds even while no server is there: ZeroMQ goes on trying.</summary>
        /// <param name="endpoint">The server, such as <c>tcp://127.0.0.1:5555</c>.</param>
        /// <exception cref="ArgumentException">The endpoint cannot work; the message names cause and cure.</exception>
        public MessageRequester(string endpoint)
        {
            this.endpoint = endpoint;
            // Above the limit of Message.cs a reply is refused by name. Above this one NetMQ takes no more and hangs up.
            connection = new NetMQConnection(endpoint, MakeSocket, 4 * Message.Limit);
        }

        /// <summary>Sends a message and waits for its reply.</summary>
        /// <param name="request">The message. Its arrays are lent, not copied: leave them alone until this returns.</param>
        /// <param name="patience">How long to wait for the reply.</param>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        /// <returns>The reply. Its arrays are only valid until the next request: their buffers are used again.</returns>
        /// <exception cref="MessageException">The reply is an error, with the server's code and text, or no message.</exception>
        /// <exception cref="TimeoutException">No reply came. The next request has a new socket, and so finds a server
        /// that is back again.</exception>
        /// <exception cref="OperationCanceledException"><paramref name="stop"/> was cancelled.</exception>
        public Message Request(Message request, TimeSpan patience, CancellationToken stop = default) =>
            Request(request.Header(), request.Arrays, patience, stop);

        /// <summary>The same for a header that is written already.</summary>
        public Message Request(string header, IReadOnlyList<MessageArray> arrays, TimeSpan patience, CancellationToken stop = default)
        {
            Message reply;
            try
            {
                Send(Encoding.UTF8.GetBytes(header), arrays.Count > 0);
                for (var i = 0; i < arrays.Count; i++) Send(arrays[i].Data, i + 1 < arrays.Count);
                Receive(patience, stop);
                reply = Message.Read(frames);
            }
            catch
            {
                // A REQ socket that waits for a reply takes no other request. A new one also never gets a late reply.
                connection.Close();
                throw;
            }
            if (reply.Kind != "error") return reply;
            reply.Values.TryGetValue("code", out var code);
            reply.Values.TryGetValue("text", out var text);
            throw new MessageException(NetMQLifetime.Printable(code as string ?? "error"),
                NetMQLifetime.Printable(text as string ?? "the server gave no reason"));
        }

        // Room for several pictures in the operating system: the two sides then wait for each other less often.
        private static RequestSocket MakeSocket() =>
            new RequestSocket { Options = { SendBuffer = 1 << 20, ReceiveBuffer = 1 << 20 } };

        private void Send(ReadOnlyMemory<byte> bytes, bool more)
        {
            var msg = new Msg();
            // Lent where it can be: the reply proves that the network has had every byte of it.
            if (MemoryMarshal.TryGetArray(bytes, out var lent)) msg.InitGC(lent.Array, lent.Offset, lent.Count);
            else
            {
                msg.InitPool(bytes.Length);
                bytes.Span.CopyTo(msg.Slice());
            }
            var sent = connection.Socket.TrySend(ref msg, NetMQConnection.Slice, more);
            // Sent, it is empty: what it held is NetMQ's until the network has it.
            msg.Close();
            if (!sent) throw new TimeoutException($"{endpoint} takes no more; is the server running?");
        }

        private void Receive(TimeSpan patience, CancellationToken stop)
        {
            frames.Clear();
            var more = true;
            // More frames than a message may have are not waited for: Message.Read refuses them.
            for (var i = 0; more && i < Message.MostArrays + 2; i++)
            {
                if (i == parts.Length)
                {
                    Array.Resize(ref parts, 2 * i + 2);
                    for (var added = i; added < parts.Length; added++) parts[added].InitEmpty();
                }
                if (!TryReceive(i, patience, stop))
                    throw new TimeoutException(FormattableString.Invariant(
                        $"no reply from {endpoint} within {patience.TotalSeconds} s; is the server running?"));
                frames.Add(parts[i].SliceAsMemory());
                more = parts[i].HasMore;
            }
        }

        private bool TryReceive(int i, TimeSpan patience, CancellationToken stop)
        {
            foreach (var slice in NetMQConnection.Slices(patience, stop))
                if (connection.Socket.TryReceive(ref parts[i], slice)) return true;
            return false;
        }

        /// <summary>Closes the socket, then leaves NetMQ.</summary>
        public void Dispose()
        {
            for (var i = 0; i < parts.Length; i++) parts[i].Close();
            parts = new Msg[0];
            connection.Dispose();
        }
    }

    /// <summary>Lends NetMQ its buffers from .NET's own pool, for all sockets of the process.</summary>
    public sealed class PooledBuffers : IBufferPool
    {
        /// <summary>From now on each new message takes its buffer from the pool.</summary>
        public static void Use() => BufferPool.SetCustomBufferPool(new PooledBuffers());

        /// <inheritdoc/>
        public byte[] Take(int size) => ArrayPool<byte>.Shared.Rent(size);

        /// <inheritdoc/>
        public void Return(byte[] buffer)
        {
            // Messages from before Use() end here too, and ArrayPool throws at any size that is not one of its own:
            // those are the powers of two from 16 on.
            if (buffer.Length >= 16 && (buffer.Length & (buffer.Length - 1)) == 0) ArrayPool<byte>.Shared.Return(buffer);
        }

        /// <summary>Nothing to do: the pool is .NET's.</summary>
        public void Dispose() { }
    }
}
