// Lesson 05, messages: ask with structure and arrays.
//
// The Python side is python/05_messages/server.py. Bytes: see Message.cs.
// Trouble: python/05_messages/client.py sends a header that does not fit its bytes with --wrong-shape; here
// MessageArray refuses to be made of them.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample
{
    /// <summary>Asks a REP server with messages. Make it, use it and dispose it on one thread, and not on Unity's main
    /// thread: a request blocks until its reply is there.</summary>
    public class MessageRequester : IDisposable
    {
        private readonly string endpoint;
        private readonly TimeSpan timeout;
        private readonly int tries;

        /// <summary>Connects, which succeeds even while no server is there: ZeroMQ goes on trying.</summary>
        /// <param name="endpoint">The server, such as <c>tcp://127.0.0.1:5555</c>.</param>
        /// <param name="timeout">How long the first try waits that is not given another time: until it is sent, and
        /// then for the reply; 2.5 s when left out. Each try waits twice as long as the one before, up to 8 times.
        /// </param>
        /// <param name="tries">How often a message is sent before it is given up. A server that has done it may do it
        /// again.</param>
        /// <exception cref="ArgumentException">One of them cannot work; the message names cause and cure.</exception>
        public MessageRequester(string endpoint, TimeSpan? timeout = null, int tries = 1)
            : this(endpoint, () => new RequestSocket(), timeout, tries)
        {
        }

        /// <summary>The same with a socket of one's own making.</summary>
        protected MessageRequester(
            string endpoint, Func<NetMQSocket> make, TimeSpan? timeout = null, int tries = 1)
        {
            this.endpoint = endpoint;
            this.timeout = Require.Seconds("timeout", timeout ?? TimeSpan.FromSeconds(2.5));
            this.tries = Require.Count("tries", tries);
            // Above the limit of Message.cs a reply is refused by name. Above this one NetMQ hangs up.
            Connection = new NetMQConnection(endpoint, make, 4 * Message.LimitBytes);
        }

        protected NetMQConnection Connection { get; }

        /// <summary>Sends a message and waits for its reply.</summary>
        /// <param name="timeout">How long the first try waits, in place of the requester's own.</param>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        /// <exception cref="MessageException">The reply is an error, with its words, or no message.</exception>
        /// <exception cref="TimeoutException">No reply came. The next request has a new socket, and so finds a server
        /// that is back again.</exception>
        /// <exception cref="OperationCanceledException"><paramref name="stop"/> was cancelled.</exception>
        public Message Request(Message request, TimeSpan? timeout = null, CancellationToken stop = default) =>
            Request(request, new Message(""), timeout, stop);

        /// <summary>The same into a message that is used again.</summary>
        internal Message Request(Message request, Message reply, TimeSpan? timeout, CancellationToken stop)
        {
            if (request == null) throw new ArgumentNullException(null, "request must not be null");
            try
            {
                var limit = timeout ?? this.timeout;
                IReadOnlyList<ReadOnlyMemory<byte>> frames;
                for (var vain = 1; !TryExchange(request, limit, stop, out frames); vain++)
                {
                    if (vain == tries) throw Connection.NoReply(limit);
                    Connection.Close();
                    limit = NetMQConnection.Longer(timeout ?? this.timeout, vain);
                }
                reply.ReadAgain(frames);
            }
            catch
            {
                // A REQ socket that waits for a reply takes no other request. A new one also never gets a late reply.
                Connection.Close();
                throw;
            }
            return reply.OrThrow();
        }

        /// <summary>Sends one message and receives another: the header, and a frame for each array.</summary>
        protected virtual bool TryExchange(
            Message request, TimeSpan timeout, CancellationToken stop, out IReadOnlyList<ReadOnlyMemory<byte>> frames)
        {
            var sent = new NetMQMessage();
            var received = new NetMQMessage();
            sent.Append(request.Header());
            foreach (var array in request.Arrays) sent.Append(array.Data.ToArray());
            frames = null;
            var slices = NetMQConnection.Slices(timeout, stop);
            // Each time it is gone through, the time begins anew.
            if (!slices.Any(slice => Connection.Socket.TrySendMultipartMessage(slice, sent))) return false;
            Connection.Show(true, sent);
            if (!slices.Any(slice => Connection.Socket.TryReceiveMultipartMessage(slice, ref received))) return false;
            Connection.Show(false, received);
            frames = received.Select(frame => new ReadOnlyMemory<byte>(frame.Buffer, 0, frame.MessageSize)).ToList();
            return true;
        }

        public override string ToString() => $"{GetType().Name} {endpoint}";
        public virtual void Dispose() => Connection.Dispose();
    }
}
