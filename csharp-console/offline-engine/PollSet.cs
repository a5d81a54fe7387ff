// Waits for several sockets at once: libzmq's zmq_poll over a table that is laid out by hand.
using System;
using System.Collections.Generic;
using System.Diagnostics;

namespace NetMQ
{
    internal sealed unsafe class PollSet
    {
        // zmq_pollitem_t: a socket, a file descriptor (a pointer's size on Windows, an int elsewhere), two shorts.
        private static readonly int eventsAt = IntPtr.Size + (Native.IsWindows ? IntPtr.Size : sizeof(int));
        private static readonly int stride
            = (eventsAt + 2 * sizeof(short) + IntPtr.Size - 1) / IntPtr.Size * IntPtr.Size;

        private readonly IReadOnlyList<NetMQSocket> sockets;
        private readonly byte[] items;

        internal PollSet(IReadOnlyList<NetMQSocket> sockets)
        {
            this.sockets = sockets;
            items = new byte[sockets.Count * stride];
            for (var i = 0; i < sockets.Count; i++) Want(i, sockets[i].WantedEvents);
        }

        internal void Want(int index, PollEvents events)
            => BitConverter.TryWriteBytes(items.AsSpan(index * stride + eventsAt),
                (short)(events & (PollEvents.PollIn | PollEvents.PollOut)));

        internal PollEvents Ready(int index)
        {
            var at = index * stride + eventsAt + sizeof(short);
            return (PollEvents)BitConverter.ToInt16(items, at);
        }

        /// <summary>Waits up to a number of milliseconds, -1 for ever; true if at least one socket is ready.</summary>
        internal bool Wait(int limit)
        {
            var start = Stopwatch.GetTimestamp();
            var left = limit;
            fixed (byte* table = items)
            {
                // A disposed socket throws here: libzmq would take its empty place for a file descriptor.
                for (var i = 0; i < sockets.Count; i++) *(IntPtr*)(table + i * stride) = sockets[i].Handle;
                while (true)
                {
                    var ready = Native.Instance.Poll(table, sockets.Count, (IntPtr)left);
                    if (ready >= 0) return ready > 0;
                    var error = Native.Instance.Error;
                    if (error != Native.Interrupted) throw NetMQSocket.Failure(error);
                    if (limit > 0) left = NetMQSocket.TimeLeft(limit, start);
                }
            }
        }
    }
}
