// A queue that any thread can fill and that a poller's thread can wait for.
using System;
using System.Collections;
using System.Collections.Concurrent;
using System.Collections.Generic;
using System.Diagnostics.CodeAnalysis;
using NetMQ.Sockets;

namespace NetMQ
{
    /// <summary>Which queue has an item.</summary>
    public sealed class NetMQQueueEventArgs<T> : EventArgs
    {
        internal NetMQQueueEventArgs(NetMQQueue<T> queue) => Queue = queue;

        /// <summary>The queue.</summary>
        public NetMQQueue<T> Queue { get; }
    }

    /// <summary>Many threads may enqueue; one thread dequeues, by itself or in a <see cref="NetMQPoller"/>.</summary>
    public sealed class NetMQQueue<T> : IDisposable, ISocketPollable, IEnumerable<T>
    {
        // The items stay in the queue; for each of them an empty frame goes from writer to reader.
        private readonly ConcurrentQueue<T> items = new ConcurrentQueue<T>();
        private readonly PairSocket writer;
        private readonly PairSocket reader;
        private readonly NetMQQueueEventArgs<T> eventArgs;
        private EventHandler<NetMQQueueEventArgs<T>>? receiveReady;

        /// <summary>Enqueue waits while the queue holds <paramref name="capacity"/> items; 0 for any number.</summary>
        public NetMQQueue(int capacity = 0)
        {
            if (capacity < 0) throw new ArgumentOutOfRangeException(nameof(capacity));
            // Two sockets within a process hold as many messages as both watermarks together.
            PairSocket.CreateSocketPair(out writer, out reader,
                socket => socket.Options.SendHighWatermark = capacity / 2,
                socket => socket.Options.ReceiveHighWatermark = capacity / 2);
            eventArgs = new NetMQQueueEventArgs<T>(this);
        }

        /// <summary>The queue has an item. Raised by a <see cref="NetMQPoller"/>.</summary>
        public event EventHandler<NetMQQueueEventArgs<T>> ReceiveReady
        {
            add
            {
                if (receiveReady == null) reader.ReceiveReady += Raise;
                receiveReady += value;
            }
            remove
            {
                receiveReady -= value;
                if (receiveReady == null) reader.ReceiveReady -= Raise;
            }
        }

        /// <summary>The number of items.</summary>
        public int Count => items.Count;

        /// <summary>True if there are no items.</summary>
        public bool IsEmpty => items.IsEmpty;

        /// <summary>True once it was disposed.</summary>
        public bool IsDisposed { get; private set; }

        NetMQSocket ISocketPollable.Socket => reader;

        /// <summary>Adds an item, from any thread.</summary>
        public void Enqueue(T value)
        {
            items.Enqueue(value);
            lock (writer) writer.TrySendBytes(default, SendReceiveConstants.InfiniteTimeout, false);
        }

        /// <summary>Takes the oldest item, or returns false if none came in time.</summary>
        public bool TryDequeue([MaybeNullWhen(false)] out T result, TimeSpan timeout)
        {
            if (reader.TrySkipFrame(timeout)) return items.TryDequeue(out result);
            result = default;
            return false;
        }

        /// <summary>Waits for an item and takes it.</summary>
        [return: MaybeNull]
        public T Dequeue()
        {
            TryDequeue(out var result, SendReceiveConstants.InfiniteTimeout);
            return result;
        }

        /// <inheritdoc/>
        public IEnumerator<T> GetEnumerator() => items.GetEnumerator();

        IEnumerator IEnumerable.GetEnumerator() => GetEnumerator();

        /// <inheritdoc/>
        public void Dispose()
        {
            if (IsDisposed) return;
            receiveReady = null;
            writer.Dispose();
            reader.Dispose();
            IsDisposed = true;
        }

        private void Raise(object? sender, NetMQSocketEventArgs e) => receiveReady?.Invoke(this, eventArgs);
    }
}
