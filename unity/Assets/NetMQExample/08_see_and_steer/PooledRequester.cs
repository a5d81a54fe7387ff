// Lesson 08, the requester for pictures: lesson 05's, which reuses its large buffers.
//
// Sending and receiving a NetMQMessage makes several new arrays of a picture's size. Arrays over 85,000 bytes are
// collected only by the slowest of .NET's collections. Smaller messages need no more than a MessageRequester.
using System;
using System.Buffers;
using System.Collections.Generic;
using System.Linq;
using System.Runtime.InteropServices;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample
{
    /// <summary>For one thread, as a MessageRequester is. A request's arrays are lent, not copied: leave them alone
    /// until <c>Request</c> returns. A reply's arrays are only valid until the next request. It helps most after
    /// <see cref="PooledBuffers.Use"/>.</summary>
    public sealed class PooledRequester : MessageRequester
    {
        // The frames of the last reply. A Msg gives its buffer back to the pool when it receives the next frame.
        private readonly List<ReadOnlyMemory<byte>> frames = new List<ReadOnlyMemory<byte>>();
        // Null while a request is on its way.
        private MessageWriter header;
        private Msg[] parts = new Msg[0];

        /// <summary>With room for several pictures in the operating system: the two sides then wait for each other less
        /// often.</summary>
        /// <inheritdoc cref="MessageRequester(string, TimeSpan?, int)"/>
        public PooledRequester(string endpoint, TimeSpan? timeout = null, int tries = 1) : base(endpoint,
            () => new RequestSocket { Options = { SendBuffer = 1 << 20, ReceiveBuffer = 1 << 20 } }, timeout, tries)
        {
        }

        protected override bool TryExchange(
            Message request, TimeSpan timeout, CancellationToken stop, out IReadOnlyList<ReadOnlyMemory<byte>> reply)
        {
            reply = frames;
            // The one of a request that was given up may still be on its way.
            var json = header ?? new MessageWriter();
            header = null;
            if (!Send(request.WriteHeader(json).Written, request.Arrays.Count > 0, timeout, stop)) return false;
            for (var i = 0; i < request.Arrays.Count; i++)
                if (!Send(request.Arrays[i].Data, i + 1 < request.Arrays.Count, timeout, stop)) return false;
            if (NetMQConnection.Watched)
                Connection.Show(true, request.Arrays.Select(array => (object)array.Data).Prepend(json.ToString()));
            frames.Clear();
            for (var i = 0; i == 0 || parts[i - 1].HasMore; i++)
            {
                if (i == parts.Length) Grow();
                if (!Receive(ref parts[i], timeout, stop)) return false;
                frames.Add(parts[i].SliceAsMemory());
            }
            header = json;
            Connection.Show(false, frames);
            return true;
        }

        // Lent where it can be: the reply proves that the network has had every byte of it.
        private bool Send(ReadOnlyMemory<byte> data, bool more, TimeSpan timeout, CancellationToken stop)
        {
            var msg = new Msg();
            if (MemoryMarshal.TryGetArray(data, out var lent)) msg.InitGC(lent.Array, lent.Offset, lent.Count);
            else
            {
                msg.InitPool(data.Length);
                data.Span.CopyTo(msg.Slice());
            }
            for (var wait = new Wait(timeout, stop); wait.Next(out var slice);)
                // Sent, it is empty: what it held is NetMQ's until the network has it.
                if (Connection.Socket.TrySend(ref msg, slice, more)) return true;
            msg.Close();
            return false;
        }

        private bool Receive(ref Msg part, TimeSpan timeout, CancellationToken stop)
        {
            for (var wait = new Wait(timeout, stop); wait.Next(out var slice);)
                if (Connection.Socket.TryReceive(ref part, slice)) return true;
            return false;
        }

        private void Grow()
        {
            var before = parts.Length;
            Array.Resize(ref parts, 2 * before + 2);
            for (var i = before; i < parts.Length; i++) parts[i].InitEmpty();
        }

        public override void Dispose()
        {
            for (var i = 0; i < parts.Length; i++) parts[i].Close();
            parts = new Msg[0];
            base.Dispose();
        }
    }

    /// <summary>Lends NetMQ its buffers from .NET's own pool, for all sockets of the process.</summary>
    public sealed class PooledBuffers : IBufferPool
    {
        /// <summary>From now on each new message takes its buffer from the pool.</summary>
        public static void Use() => BufferPool.SetCustomBufferPool(new PooledBuffers());

        public byte[] Take(int size) => ArrayPool<byte>.Shared.Rent(size);

        public void Return(byte[] buffer)
        {
            // Messages from before Use() end here too, and ArrayPool throws at any size that is not one of its own:
            // those are the powers of two from 16 on.
            var powerOfTwo = (buffer.Length & (buffer.Length - 1)) == 0;
            if (buffer.Length >= 16 && powerOfTwo) ArrayPool<byte>.Shared.Return(buffer);
        }

        public void Dispose() { }
    }
}
