// Lesson 12, a DEALER socket for lesson 05's messages, whose arrays it lends to the network instead of copying them.
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

        /// <summary>Connects, which succeeds even while nobody is there.</summary>
        /// <param name="endpoint">Such as <c>tcp://127.0.0.1:5562</c>.</param>
        /// <param name="timeout">How long to wait until a message is sent; 30 s when left out.</param>
        /// <exception cref="ArgumentException">One of them cannot work; the message names cause and cure.</exception>
        public MessageDealer(string endpoint, TimeSpan? timeout = null)
        {
            this.endpoint = endpoint;
            this.timeout = Require.Seconds("timeout", timeout ?? TimeSpan.FromSeconds(30));
            connection = new NetMQConnection(endpoint, () => new DealerSocket
            {
                // Nothing can be sent while there is no connection. Lesson 09 says why a silent peer is asked.
                Options = { DelayAttachOnConnect = true, ReconnectInterval = TimeSpan.FromSeconds(0.5),
                    HeartbeatInterval = TimeSpan.FromSeconds(1), HeartbeatTimeout = TimeSpan.FromSeconds(2) },
            }, 4 * Message.LimitBytes);
        }

        public TimeSpan Timeout { get => timeout; set => timeout = Require.Seconds("timeout", value); }

        /// <summary>Sends a message. Its arrays are lent: leave them alone until the other side says that it has
        /// them.</summary>
        /// <exception cref="TimeoutException">Nobody is there.</exception>
        public void Send(Message message, CancellationToken stop)
        {
            var header = message.Header();
            Send(Encoding.UTF8.GetBytes(header), message.Arrays.Count > 0, stop);
            for (var i = 0; i < message.Arrays.Count; i++)
            {
                var data = message.Arrays[i].Data;
                var whole = MemoryMarshal.TryGetArray(data, out var lent) && lent.Count == lent.Array.Length;
                Send(whole ? lent.Array : data.ToArray(), i + 1 < message.Arrays.Count, stop);
            }
            connection.Show(true, message.Arrays.Select(array => (object)array.Data).Prepend(header));
        }

        /// <summary>Waits for a message.</summary>
        /// <returns>Null if none came.</returns>
        /// <exception cref="TimeoutException">Nobody is there any more.</exception>
        /// <exception cref="MessageException">It is an error, with its words, or no message.</exception>
        public Message Receive(TimeSpan wait, CancellationToken stop)
        {
            var frames = new NetMQMessage();
            foreach (var slice in NetMQConnection.Slices(wait, stop))
            {
                if (!connection.Socket.TryReceiveMultipartMessage(slice, ref frames))
                {
                    // Its last message may have come meanwhile.
                    if (connection.Socket.HasOut || connection.Socket.HasIn) continue;
                    throw new TimeoutException("Python is gone");
                }
                connection.Show(false, frames);
                return Message.Read(
                    frames.Select(frame => new ReadOnlyMemory<byte>(frame.Buffer, 0, frame.MessageSize)).ToList())
                    .OrThrow();
            }
            return null;
        }

        /// <summary>The last message may still go out for a moment when the socket is closed.</summary>
        public void Flush() => connection.Socket.Options.Linger = TimeSpan.FromMilliseconds(200);

        /// <summary>The next message has a new socket.</summary>
        public void Close() => connection.Close();

        public override string ToString() => $"MessageDealer {endpoint}";
        public void Dispose() => connection.Dispose();

        private void Send(byte[] bytes, bool more, CancellationToken stop)
        {
            var msg = new Msg();
            msg.InitGC(bytes, 0, bytes.Length);
            foreach (var slice in NetMQConnection.Slices(timeout, stop))
            {
                if (!connection.Socket.TrySend(ref msg, slice, more)) continue;
                // No second connection comes without a hello: lesson 09 says why.
                connection.Socket.Options.ReconnectInterval = System.Threading.Timeout.InfiniteTimeSpan;
                return;
            }
            throw new TimeoutException("no connection");
        }
    }
}
