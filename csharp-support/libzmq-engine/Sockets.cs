// The kinds of sockets, each with its default for an address without @ or >.
using System;
using System.Text;
using System.Threading;

namespace NetMQ.Sockets
{
    /// <summary>Asks: sends a request, then receives its reply, strictly in turn.</summary>
    public class RequestSocket : NetMQSocket
    {
        /// <summary>Connects to each address, unless it begins with @.</summary>
        public RequestSocket(string? connectionString = null)
            : base(ZmqSocketType.Req, connectionString, DefaultAction.Connect) { }
    }

    /// <summary>Answers: receives a request, then sends its reply, strictly in turn.</summary>
    public class ResponseSocket : NetMQSocket
    {
        /// <summary>Binds to each address, unless it begins with &gt;.</summary>
        public ResponseSocket(string? connectionString = null)
            : base(ZmqSocketType.Rep, connectionString, DefaultAction.Bind) { }
    }

    /// <summary>Asks without waiting for its turn.</summary>
    public class DealerSocket : NetMQSocket
    {
        /// <summary>Connects to each address, unless it begins with @.</summary>
        public DealerSocket(string? connectionString = null)
            : base(ZmqSocketType.Dealer, connectionString, DefaultAction.Connect) { }
    }

    /// <summary>Answers many peers: each message begins with the identity of its peer.</summary>
    public class RouterSocket : NetMQSocket
    {
        /// <summary>Binds to each address, unless it begins with &gt;.</summary>
        public RouterSocket(string? connectionString = null)
            : base(ZmqSocketType.Router, connectionString, DefaultAction.Bind) { }
    }

    /// <summary>Sends work to one peer after the other.</summary>
    public class PushSocket : NetMQSocket
    {
        /// <summary>Connects to each address, unless it begins with @.</summary>
        public PushSocket(string? connectionString = null)
            : base(ZmqSocketType.Push, connectionString, DefaultAction.Connect) { }

        /// <summary>Not supported.</summary>
        public override bool TryReceive(ref Msg msg, TimeSpan timeout) => TryReceiveFrame(timeout);

        internal override bool TryReceiveFrame(TimeSpan timeout)
            => throw new NotSupportedException("PushSocket doesn't support receiving");
    }

    /// <summary>Receives work from all peers in turn.</summary>
    public class PullSocket : NetMQSocket
    {
        /// <summary>Binds to each address, unless it begins with &gt;.</summary>
        public PullSocket(string? connectionString = null)
            : base(ZmqSocketType.Pull, connectionString, DefaultAction.Bind) { }

        /// <summary>Not supported.</summary>
        public override bool TrySend(ref Msg msg, TimeSpan timeout, bool more) => TrySendBytes(default, timeout, more);

        internal override bool TrySendBytes(ReadOnlySpan<byte> data, TimeSpan timeout, bool more)
            => throw new NotSupportedException("Pull socket doesn't support sending");
    }

    /// <summary>Talks to exactly one peer.</summary>
    public class PairSocket : NetMQSocket
    {
        private static int pairs;

        /// <summary>Connects to each address, unless it begins with @.</summary>
        public PairSocket(string? connectionString = null)
            : base(ZmqSocketType.Pair, connectionString, DefaultAction.Connect) { }

        /// <summary>Two sockets that are connected within the process.</summary>
        public static void CreateSocketPair(out PairSocket socket1, out PairSocket socket2)
            => CreateSocketPair(out socket1, out socket2, _ => { }, _ => { });

        /// <summary>Two sockets that are connected within the process, each prepared before that.</summary>
        public static void CreateSocketPair(out PairSocket socket1, out PairSocket socket2,
            Action<PairSocket> initSocket1, Action<PairSocket> initSocket2)
        {
            var address = $"inproc://NetMQSocketPair#{Interlocked.Increment(ref pairs)}";
            socket1 = new PairSocket();
            initSocket1(socket1);
            socket1.Bind(address);
            socket2 = new PairSocket();
            initSocket2(socket2);
            socket2.Connect(address);
        }
    }

    /// <summary>Sends each message to all who subscribed to how it begins.</summary>
    public class PublisherSocket : NetMQSocket
    {
        /// <summary>Binds to each address, unless it begins with &gt;.</summary>
        public PublisherSocket(string? connectionString = null)
            : base(ZmqSocketType.Pub, connectionString, DefaultAction.Bind) { }

        /// <summary>Not supported.</summary>
        public override bool TryReceive(ref Msg msg, TimeSpan timeout) => TryReceiveFrame(timeout);

        internal override bool TryReceiveFrame(TimeSpan timeout)
            => throw new NotSupportedException("PublisherSocket doesn't support receiving");
    }

    /// <summary>Receives what it subscribed to: messages whose first frame begins with the topic.</summary>
    public class SubscriberSocket : NetMQSocket
    {
        /// <summary>Connects to each address, unless it begins with @.</summary>
        public SubscriberSocket(string? connectionString = null)
            : base(ZmqSocketType.Sub, connectionString, DefaultAction.Connect) { }

        /// <summary>Subscribes to a topic in ASCII.</summary>
        public virtual void Subscribe(string topic) => Subscribe(topic, Encoding.ASCII);

        /// <summary>Subscribes to a topic.</summary>
        public virtual void Subscribe(string topic, Encoding encoding) => Subscribe(encoding.GetBytes(topic));

        /// <summary>Subscribes to a topic.</summary>
        public virtual void Subscribe(byte[] topic) => SetBytes(Option.Subscribe, topic);

        /// <summary>Subscribes to everything.</summary>
        public virtual void SubscribeToAnyTopic() => Subscribe(string.Empty);

        /// <summary>Undoes a subscription to a topic in ASCII.</summary>
        public virtual void Unsubscribe(string topic) => Unsubscribe(topic, Encoding.ASCII);

        /// <summary>Undoes a subscription.</summary>
        public virtual void Unsubscribe(string topic, Encoding encoding) => Unsubscribe(encoding.GetBytes(topic));

        /// <summary>Undoes a subscription.</summary>
        public virtual void Unsubscribe(byte[] topic) => SetBytes(Option.Unsubscribe, topic);

        /// <summary>Not supported.</summary>
        public override bool TrySend(ref Msg msg, TimeSpan timeout, bool more) => TrySendBytes(default, timeout, more);

        internal override bool TrySendBytes(ReadOnlySpan<byte> data, TimeSpan timeout, bool more)
            => throw new NotSupportedException("Subscriber socket doesn't support sending");
    }

    /// <summary>A publisher that receives the subscriptions as messages: a byte 1 or 0, then the topic.</summary>
    public class XPublisherSocket : NetMQSocket
    {
        /// <summary>Binds to each address, unless it begins with &gt;.</summary>
        public XPublisherSocket(string? connectionString = null)
            : base(ZmqSocketType.Xpub, connectionString, DefaultAction.Bind) { }

        /// <summary>The first message that each new subscriber gets.</summary>
        public void SetWelcomeMessage(byte[] welcomeMessage) => SetBytes(Option.XPubWelcome, welcomeMessage);

        /// <summary>The first message that each new subscriber gets, in ASCII.</summary>
        public void SetWelcomeMessage(string welcomeMessage) => SetWelcomeMessage(welcomeMessage, Encoding.ASCII);

        /// <summary>The first message that each new subscriber gets.</summary>
        public void SetWelcomeMessage(string welcomeMessage, Encoding encoding)
            => SetWelcomeMessage(encoding.GetBytes(welcomeMessage));

        /// <summary>No such message.</summary>
        public void ClearWelcomeMessage() => SetBytes(Option.XPubWelcome, null);
    }

    /// <summary>A subscriber that sends its subscriptions as messages: a byte 1 or 0, then the topic.</summary>
    public class XSubscriberSocket : NetMQSocket
    {
        /// <summary>Connects to each address, unless it begins with @.</summary>
        public XSubscriberSocket(string? connectionString = null)
            : base(ZmqSocketType.Xsub, connectionString, DefaultAction.Connect) { }
    }
}
