// Lessons 09 and 12, a DEALER socket for lesson 05's messages, and for lesson 09's records.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Runtime.InteropServices;
using System.Text;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample
{
    /// <summary>Make it, use it and dispose it on one thread, and not on Unity's main thread: it waits.</summary>
    public sealed class MessageDealer : IDisposable
    {
        private readonly NetMQConnection connection;
        private readonly string endpoint;
        private TimeSpan timeout;
        private Msg received;

        /// <summary>Connects, which succeeds even while nobody is there.</summary>
        /// <param name="endpoint">Such as <c>tcp://127.0.0.1:5562</c>.</param>
        /// <param name="timeout">How long to wait until a message is sent; 30 s when left out.</param>
        /// <exception cref="ArgumentException">One of them cannot work; the message names cause and cure.</exception>
        public MessageDealer(string endpoint, TimeSpan? timeout = null)
        {
            this.endpoint = endpoint;
            this.timeout = Require.Seconds("timeout", timeout ?? TimeSpan.FromSeconds(30));
            received.InitEmpty();
            connection = new NetMQConnection(endpoint, () => new DealerSocket
            {
                // Nothing can be sent while there is no connection.
                // A pulled cable tells nobody: a silent peer is asked after a second, and gone when two more bring no
                // answer.
                Options = { DelayAttachOnConnect = true, ReconnectInterval = TimeSpan.FromSeconds(0.5),
                    HeartbeatInterval = TimeSpan.FromSeconds(1), HeartbeatTimeout = TimeSpan.FromSeconds(2) },
            }, 4 * Message.LimitBytes);
        }

        public TimeSpan Timeout { get => timeout; set => timeout = Require.Seconds("timeout", value); }

        // Why there is nobody any more.
        internal string Gone { get; set; } = "Python is gone";

        /// <summary>Sends a message. Its arrays are lent, unless they are to be copied: leave them alone until the
        /// other side says that it has them.</summary>
        /// <exception cref="TimeoutException">Nobody is there.</exception>
        public void Send(Message message, CancellationToken stop, bool copies = false)
        {
            var header = message.Header();
            Send(Encoding.UTF8.GetBytes(header), message.Arrays.Count > 0, stop);
            for (var i = 0; i < message.Arrays.Count; i++)
            {
                var data = message.Arrays[i].Data;
                var lends = MemoryMarshal.TryGetArray(data, out var lent) && lent.Count == lent.Array.Length && !copies;
                Send(lends ? lent.Array : data.ToArray(), i + 1 < message.Arrays.Count, stop);
            }
            if (NetMQConnection.Watched)
                connection.Show(true, message.Arrays.Select(array => (object)array.Data).Prepend(header));
            // From now on it makes no second connection: that might come between two looks, without a hello, and both
            // sides would wait for each other.
            connection.Socket.Options.ReconnectInterval = System.Threading.Timeout.InfiniteTimeSpan;
        }

        /// <summary>Waits for a message.</summary>
        /// <returns>Null if none came.</returns>
        /// <exception cref="TimeoutException">Nobody is there any more.</exception>
        /// <exception cref="MessageException">It is an error, with its words, or no message.</exception>
        public Message Receive(TimeSpan wait, CancellationToken stop) => TryReceive(wait, stop) ? Read() : null;

        /// <summary>The last message may still go out for a moment when the socket is closed.</summary>
        public void Flush(double seconds = 0.2) => connection.Socket.Options.Linger = TimeSpan.FromSeconds(seconds);

        /// <summary>The next message has a new socket.</summary>
        public void Close() => connection.Close();

        public override string ToString() => $"MessageDealer {endpoint}";

        public void Dispose()
        {
            // A second Close would throw.
            if (received.IsInitialised) received.Close();
            connection.Dispose();
        }

        internal string Cure(string otherwise) => connection.Cure(otherwise);

        // A record, which is copied, without garbage.
        internal void Send(ReadOnlySpan<byte> record, CancellationToken stop)
        {
            var msg = new Msg();
            msg.InitPool(record.Length);
            record.CopyTo(msg.Slice());
            connection.Show(true, new[] { msg.CloneData() });
            Send(ref msg, false, stop);
        }

        /// <summary>Waits for the first frame of a message: then it is a record, or to be read.</summary>
        /// <exception cref="TimeoutException">Nobody is there any more.</exception>
        internal bool TryReceive(TimeSpan wait, CancellationToken stop)
        {
            foreach (var slice in NetMQConnection.Slices(wait, stop))
            {
                if (connection.Socket.TryReceive(ref received, slice)) return true;
                // Its last message may have come meanwhile.
                if (!connection.Socket.HasOut && !connection.Socket.HasIn) throw new TimeoutException(Gone);
            }
            return false;
        }

        // The bytes of a record are good until the next one comes.
        internal bool IsRecord(out ReadOnlyMemory<byte> record)
        {
            record = received.SliceAsMemory();
            if (received.HasMore || !StepRequest.Is(record.Span)) return false;
            connection.Show(false, new[] { received.CloneData() });
            return true;
        }

        // All frames of a message are there as soon as the first one is.
        internal Message Read()
        {
            var frames = new List<ReadOnlyMemory<byte>> { received.CloneData() };
            while (received.HasMore)
            {
                connection.Socket.Receive(ref received);
                frames.Add(received.CloneData());
            }
            connection.Show(false, frames);
            return Message.Read(frames).OrThrow();
        }

        private void Send(byte[] bytes, bool more, CancellationToken stop)
        {
            var msg = new Msg();
            msg.InitGC(bytes, 0, bytes.Length);
            Send(ref msg, more, stop);
        }

        private void Send(ref Msg msg, bool more, CancellationToken stop)
        {
            foreach (var slice in NetMQConnection.Slices(timeout, stop))
                // Sent, it is empty: what it held is NetMQ's until the network has it.
                if (connection.Socket.TrySend(ref msg, slice, more)) return;
            msg.Close();
            throw new TimeoutException("no connection");
        }
    }
}
