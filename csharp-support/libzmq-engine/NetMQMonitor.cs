// Reports what happens to a socket's connections. libzmq sends the reports to a PAIR socket; nothing calls back.
using System;
using System.Text;
using System.Threading;
using System.Threading.Tasks;
using NetMQ.Monitoring;
using NetMQ.Sockets;

namespace NetMQ
{
    /// <summary>What a monitor can report.</summary>
    [Flags]
    public enum SocketEvents
    {
        /// <summary>A connection was made.</summary>
        Connected = 1,
        /// <summary>Connecting takes a while.</summary>
        ConnectDelayed = 2,
        /// <summary>Connecting is tried again.</summary>
        ConnectRetried = 4,
        /// <summary>The socket listens.</summary>
        Listening = 8,
        /// <summary>The socket could not listen.</summary>
        BindFailed = 16,
        /// <summary>A peer connected.</summary>
        Accepted = 32,
        /// <summary>A peer could not connect.</summary>
        AcceptFailed = 64,
        /// <summary>A connection was closed from here.</summary>
        Closed = 128,
        /// <summary>A connection could not be closed.</summary>
        CloseFailed = 256,
        /// <summary>A connection was lost.</summary>
        Disconnected = 512,
        /// <summary>All of them.</summary>
        All = 1023,
    }
}

namespace NetMQ.Monitoring
{
    /// <summary>A report.</summary>
    public abstract class NetMQMonitorEventArgs : EventArgs
    {
        /// <summary>What happened, and where.</summary>
        protected NetMQMonitorEventArgs(NetMQMonitor monitor, string address, SocketEvents socketEvent)
        {
            Monitor = monitor;
            Address = address;
            SocketEvent = socketEvent;
        }

        /// <summary>The monitor.</summary>
        public NetMQMonitor Monitor { get; }

        /// <summary>The address of the connection.</summary>
        public string Address { get; }

        /// <summary>What happened.</summary>
        public SocketEvents SocketEvent { get; }
    }

    /// <summary>A report about a connection.</summary>
    public class NetMQMonitorSocketEventArgs : NetMQMonitorEventArgs
    {
        internal NetMQMonitorSocketEventArgs(NetMQMonitor monitor, string address, SocketEvents socketEvent)
            : base(monitor, address, socketEvent) { }
    }

    /// <summary>A report about a failure.</summary>
    public class NetMQMonitorErrorEventArgs : NetMQMonitorEventArgs
    {
        /// <summary>What failed, and why.</summary>
        public NetMQMonitorErrorEventArgs(NetMQMonitor monitor, string address, ErrorCode errorCode,
            SocketEvents socketEvent)
            : base(monitor, address, socketEvent) => ErrorCode = errorCode;

        /// <summary>Why it failed.</summary>
        public ErrorCode ErrorCode { get; }
    }

    /// <summary>A report about another attempt.</summary>
    public class NetMQMonitorIntervalEventArgs : NetMQMonitorEventArgs
    {
        /// <summary>After how many milliseconds.</summary>
        public NetMQMonitorIntervalEventArgs(NetMQMonitor monitor, string address, int interval,
            SocketEvents socketEvent)
            : base(monitor, address, socketEvent) => Interval = interval;

        /// <summary>After how many milliseconds.</summary>
        public int Interval { get; }
    }

    /// <summary>
    /// Watches one socket: on a thread of its own (Start, StartAsync), or in a poller (AttachToPoller).
    /// </summary>
    public class NetMQMonitor : IDisposable
    {
        private readonly NetMQSocket reports;
        private readonly bool ownsSocket;
        private readonly ManualResetEvent stopped = new ManualResetEvent(true);
        private INetMQPoller? poller;
        private volatile bool cancelled;

        /// <summary>Makes the socket report to an in-process address that nobody else uses.</summary>
        public NetMQMonitor(NetMQSocket monitoredSocket, string endpoint, SocketEvents eventsToMonitor)
            : this(Monitored(monitoredSocket, endpoint, eventsToMonitor), endpoint, true) { }

        /// <summary>Reads reports with a PAIR socket that the program made.</summary>
        public NetMQMonitor(NetMQSocket socket, string endpoint, bool ownsSocket = false)
        {
            Endpoint = endpoint;
            reports = socket;
            this.ownsSocket = ownsSocket;
            reports.ReceiveReady += Read;
        }

        /// <summary>Any report.</summary>
        public event EventHandler<NetMQMonitorEventArgs>? EventReceived;

        /// <summary>A connection was made.</summary>
        public event EventHandler<NetMQMonitorSocketEventArgs>? Connected;

        /// <summary>Connecting takes a while.</summary>
        public event EventHandler<NetMQMonitorErrorEventArgs>? ConnectDelayed;

        /// <summary>Connecting is tried again.</summary>
        public event EventHandler<NetMQMonitorIntervalEventArgs>? ConnectRetried;

        /// <summary>The socket listens.</summary>
        public event EventHandler<NetMQMonitorSocketEventArgs>? Listening;

        /// <summary>The socket could not listen.</summary>
        public event EventHandler<NetMQMonitorErrorEventArgs>? BindFailed;

        /// <summary>A peer connected.</summary>
        public event EventHandler<NetMQMonitorSocketEventArgs>? Accepted;

        /// <summary>A peer could not connect.</summary>
        public event EventHandler<NetMQMonitorErrorEventArgs>? AcceptFailed;

        /// <summary>A connection was closed from here.</summary>
        public event EventHandler<NetMQMonitorSocketEventArgs>? Closed;

        /// <summary>A connection could not be closed.</summary>
        public event EventHandler<NetMQMonitorErrorEventArgs>? CloseFailed;

        /// <summary>A connection was lost.</summary>
        public event EventHandler<NetMQMonitorSocketEventArgs>? Disconnected;

        /// <summary>Where the reports come from.</summary>
        public string Endpoint { get; }

        /// <summary>True while it watches.</summary>
        public bool IsRunning { get; private set; }

        /// <summary>How often <see cref="Start"/> looks whether it is to stop.</summary>
        public TimeSpan Timeout { get; set; } = TimeSpan.FromSeconds(0.5);

        /// <summary>Watches on this thread until <see cref="Stop"/>.</summary>
        public void Start()
        {
            CheckCanStart();
            try
            {
                Open();
                while (!cancelled) reports.Poll(Timeout);
            }
            finally
            {
                Shut();
            }
        }

        /// <summary>Watches on another thread until <see cref="Stop"/>.</summary>
        public Task StartAsync()
        {
            CheckCanStart();
            return Task.Factory.StartNew(Start);
        }

        /// <summary>Ends <see cref="Start"/> and waits for that.</summary>
        public void Stop()
        {
            if (poller != null)
            {
                throw new InvalidOperationException("Monitor attached to a poller: detach it instead of stopping it");
            }
            cancelled = true;
            stopped.WaitOne();
        }

        /// <summary>Watches in a poller.</summary>
        public void AttachToPoller<T>(T poller) where T : INetMQPoller
        {
            if (poller == null) throw new ArgumentNullException(nameof(poller));
            if (IsRunning) throw new InvalidOperationException("Monitor already started");
            if (Interlocked.CompareExchange(ref this.poller, poller, null) != null)
            {
                throw new InvalidOperationException("Already attached to a poller");
            }
            Open();
            poller.Add(reports);
        }

        /// <summary>Watches in a poller no longer.</summary>
        public void DetachFromPoller() => Detach(false);

        /// <inheritdoc/>
        public void Dispose()
        {
            Dispose(true);
            GC.SuppressFinalize(this);
        }

        /// <summary>Ends watching.</summary>
        protected virtual void Dispose(bool disposing)
        {
            if (!disposing) return;
            var attached = poller != null;
            if (attached) Detach(ownsSocket);
            else if (!stopped.WaitOne(0)) Stop();
            reports.ReceiveReady -= Read;
            stopped.Dispose();
            if (ownsSocket && !attached) reports.Dispose();
        }

        private static PairSocket Monitored(NetMQSocket socket, string endpoint, SocketEvents events)
        {
            socket.Monitor(endpoint, events);
            var reports = new PairSocket();
            reports.Options.Linger = TimeSpan.Zero;
            return reports;
        }

        private void CheckCanStart()
        {
            if (IsRunning) throw new InvalidOperationException("Monitor already started");
            if (poller != null) throw new InvalidOperationException("Monitor attached to a poller");
        }

        private void Open()
        {
            stopped.Reset();
            IsRunning = true;
            // No limit: libzmq would wait for room, NetMQ would drop reports.
            reports.Options.ReceiveHighWatermark = 0;
            reports.MonitoredAt(Endpoint)?.Report(true);
            reports.Connect(Endpoint);
        }

        private void Shut()
        {
            try
            {
                reports.MonitoredAt(Endpoint)?.Report(false);
            }
            catch (TerminatingException)
            {
                // Cleanup ended the reports already.
            }
            finally
            {
                IsRunning = false;
                stopped.Set();
            }
        }

        private void Detach(bool dispose)
        {
            var from = poller ?? throw new InvalidOperationException("Not attached to a poller");
            // Before the socket goes: libzmq waits for ever to report what nobody can hear any more, and holds a lock
            // meanwhile that the end of the reports needs.
            Shut();
            if (dispose) from.RemoveAndDispose(reports);
            else from.Remove(reports);
            poller = null;
        }

        private void Read(object? sender, NetMQSocketEventArgs e)
        {
            // Two frames: a 16-bit event and a 32-bit value in the machine's order, then the address.
            var head = reports.ReceiveFrameBytes();
            var address = reports.ReceiveFrameString(Encoding.ASCII);
            var what = (SocketEvents)BitConverter.ToUInt16(head, 0);
            var value = BitConverter.ToInt32(head, 2);
            switch (what)
            {
                case SocketEvents.ConnectDelayed: Raise(ConnectDelayed, Error()); break;
                case SocketEvents.BindFailed: Raise(BindFailed, Error()); break;
                case SocketEvents.AcceptFailed: Raise(AcceptFailed, Error()); break;
                case SocketEvents.CloseFailed: Raise(CloseFailed, Error()); break;
                case SocketEvents.Connected: Raise(Connected, Plain()); break;
                case SocketEvents.Listening: Raise(Listening, Plain()); break;
                case SocketEvents.Accepted: Raise(Accepted, Plain()); break;
                case SocketEvents.Closed: Raise(Closed, Plain()); break;
                case SocketEvents.Disconnected: Raise(Disconnected, Plain()); break;
                case SocketEvents.ConnectRetried:
                    Raise(ConnectRetried, new NetMQMonitorIntervalEventArgs(this, address, value, what));
                    break;
            }

            NetMQMonitorSocketEventArgs Plain() => new NetMQMonitorSocketEventArgs(this, address, what);
            NetMQMonitorErrorEventArgs Error()
                => new NetMQMonitorErrorEventArgs(this, address, Native.ToErrorCode(value), what);
        }

        private void Raise<T>(EventHandler<T>? handler, T args) where T : NetMQMonitorEventArgs
        {
            EventReceived?.Invoke(this, args);
            handler?.Invoke(this, args);
        }
    }
}
