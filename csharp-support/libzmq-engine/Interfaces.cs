// The interfaces and small types that sockets, pollers and queues share.
using System;
using System.Text;

namespace NetMQ
{
    internal enum ZmqSocketType
    {
        Pair = 0, Pub = 1, Sub = 2, Req = 3, Rep = 4, Dealer = 5, Router = 6, Pull = 7, Push = 8, Xpub = 9, Xsub = 10,
    }

    /// <summary>What a socket can be ready for.</summary>
    [Flags]
    public enum PollEvents
    {
        /// <summary>Nothing.</summary>
        None = 0,
        /// <summary>A message can be received.</summary>
        PollIn = 1,
        /// <summary>A message can be sent.</summary>
        PollOut = 2,
        /// <summary>Something failed.</summary>
        PollError = 4,
    }

    /// <summary>Questions to <see cref="PollEvents"/>.</summary>
    public static class PollEventsExtensions
    {
        /// <summary>True if a message can be received.</summary>
        public static bool HasIn(this PollEvents pollEvents) => (pollEvents & PollEvents.PollIn) != 0;

        /// <summary>True if a message can be sent.</summary>
        public static bool HasOut(this PollEvents pollEvents) => (pollEvents & PollEvents.PollOut) != 0;

        /// <summary>True if something failed.</summary>
        public static bool HasError(this PollEvents pollEvents) => (pollEvents & PollEvents.PollError) != 0;
    }

    /// <summary>What methods without an encoding or a timeout use.</summary>
    public static class SendReceiveConstants
    {
        /// <summary>UTF-8.</summary>
        public static readonly Encoding DefaultEncoding = Encoding.UTF8;

        /// <summary>For ever.</summary>
        public static readonly TimeSpan InfiniteTimeout = TimeSpan.FromMilliseconds(-1);
    }

    /// <summary>Something that sends.</summary>
    public interface IOutgoingSocket
    {
        /// <summary>Sends one frame, or returns false if that was not possible in time.</summary>
        bool TrySend(ref Msg msg, TimeSpan timeout, bool more);
    }

    /// <summary>Something that receives.</summary>
    public interface IReceivingSocket
    {
        /// <summary>Receives one frame, or returns false if none came in time.</summary>
        bool TryReceive(ref Msg msg, TimeSpan timeout);
    }

    /// <summary>Something that a <see cref="NetMQPoller"/> can watch.</summary>
    public interface ISocketPollable
    {
        /// <summary>The socket to watch.</summary>
        NetMQSocket Socket { get; }

        /// <summary>True once it was disposed.</summary>
        bool IsDisposed { get; }
    }

    /// <summary>What every socket can do.</summary>
    public interface INetMQSocket : IOutgoingSocket, IReceivingSocket, ISocketPollable, IDisposable
    {
        /// <summary>A message can be received.</summary>
        event EventHandler<NetMQSocketEventArgs> ReceiveReady;

        /// <summary>A message can be sent.</summary>
        event EventHandler<NetMQSocketEventArgs> SendReady;

        /// <summary>The settings.</summary>
        SocketOptions Options { get; }

        /// <summary>True if a message can be received now.</summary>
        bool HasIn { get; }

        /// <summary>True if a message can be sent now.</summary>
        bool HasOut { get; }

        /// <summary>Listens at an address.</summary>
        void Bind(string address);

        /// <summary>Listens at a free port, and returns it.</summary>
        int BindRandomPort(string address);

        /// <summary>Connects to an address, now or as soon as somebody listens there.</summary>
        void Connect(string address);

        /// <summary>Undoes <see cref="Connect"/>.</summary>
        void Disconnect(string address);

        /// <summary>Undoes <see cref="Bind"/>.</summary>
        void Unbind(string address);

        /// <summary>Ends the socket.</summary>
        void Close();

        /// <summary>Waits until the socket is ready and raises its events.</summary>
        void Poll();

        /// <summary>Waits until the socket is ready and raises its events.</summary>
        bool Poll(TimeSpan timeout);

        /// <summary>Waits until the socket is ready, without events.</summary>
        PollEvents Poll(PollEvents pollEvents, TimeSpan timeout);

        /// <summary>Reports what happens to the socket at an in-process address.</summary>
        void Monitor(string endpoint, SocketEvents events = SocketEvents.All);
    }

    /// <summary>Which socket is ready for what.</summary>
    public class NetMQSocketEventArgs : EventArgs
    {
        /// <summary>For one socket.</summary>
        public NetMQSocketEventArgs(NetMQSocket socket) => Socket = socket;

        /// <summary>The socket.</summary>
        public NetMQSocket Socket { get; }

        /// <summary>True if a message can be received.</summary>
        public bool IsReadyToReceive { get; private set; }

        /// <summary>True if a message can be sent.</summary>
        public bool IsReadyToSend { get; private set; }

        internal void Init(PollEvents events)
        {
            IsReadyToReceive = events.HasIn();
            IsReadyToSend = events.HasOut();
        }
    }
}
