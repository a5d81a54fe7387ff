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
            var wait = NetMQSocket.OneWait(limit);
            var entered = 0;
            fixed (byte* table = items)
            {
                try
                {
                    // A disposed socket throws here: libzmq would take its empty place for a file descriptor.
                    for (; entered < sockets.Count; entered++)
                    {
                        *(IntPtr*)(table + entered * stride) = sockets[entered].Enter();
                    }
                    while (true)
                    {
                        // Looked for before the wait, which ends if the socket was first removed from a poller.
                        NetMQSocket? gone = null;
                        foreach (var socket in sockets) gone = socket.IsDisposed ? socket : gone;
                        var ready = Native.Instance.Poll(table, sockets.Count, (IntPtr)wait);
                        if (ready > 0) return true;
                        var error = ready < 0 ? Native.Instance.Error : 0;
                        if (ready < 0 && error != Native.Interrupted) throw NetMQSocket.Failure(error);
                        gone?.CheckOpen();
                        if (limit > 0) wait = NetMQSocket.OneWait(NetMQSocket.TimeLeft(limit, start));
                        if (ready == 0 && wait == 0) return false;
                    }
                }
                finally
                {
                    while (entered > 0) sockets[--entered].Leave();
                }
            }
        }
    }
}
