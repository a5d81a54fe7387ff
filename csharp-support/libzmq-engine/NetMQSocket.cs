// The base of all sockets: addresses, sending, receiving and waiting.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Globalization;
using System.Net.Sockets;
using System.Runtime.InteropServices;
using System.Text;
using System.Threading;

namespace NetMQ
{
    /// <summary>A ZeroMQ socket. It belongs to one thread: make it, use it and dispose it there.</summary>
    public abstract unsafe class NetMQSocket : INetMQSocket
    {
        internal enum DefaultAction
        {
            Connect,
            Bind,
        }

        // A frame up to this size lives inside libzmq's message; a larger one is freed as soon as it was read.
        private const int InlineSize = 32;

        // How long one wait inside libzmq is, at most: nobody can wake it when another thread disposes the socket.
        internal const int Slice = 100;

        private readonly Context context;
        private readonly Native native;
        private readonly ZmqSocketType type;
        private readonly NetMQSocketEventArgs eventArgs;
        // NetMQ finds an endpoint by the text that Bind or Connect got, libzmq by the resolved one.
        private readonly Dictionary<string, string> endpoints = new Dictionary<string, string>();
        private EventHandler<NetMQSocketEventArgs>? receiveReady;
        private EventHandler<NetMQSocketEventArgs>? sendReady;
        private PollSet? pollSet;
        private string? monitorEndpoint;
        private SocketEvents monitorEvents;
        private IntPtr handle;
        private byte* message;
        private int frameSize;
        private int receiveLimit = -1;
        private int sendLimit = -1;
        // Whether the first frames of a message were sent, and not yet its last.
        private bool amid;
        private volatile int closed;
        // The calls that are in libzmq now, and one for the socket that is not disposed.
        private int users = 1;
        private int ended;

        internal NetMQSocket(ZmqSocketType type, string? connectionString, DefaultAction defaultAction)
        {
            this.type = type;
            context = NetMQConfig.Context;
            native = context.Native;
            handle = context.NewSocket(type);
            message = (byte*)Marshal.AllocHGlobal(Native.MessageSize);
            native.InitMessage(message);
            eventArgs = new NetMQSocketEventArgs(this);
            Options = new SocketOptions(this);
            try
            {
                Options.Linger = NetMQConfig.Linger;
                foreach (var part in (connectionString ?? "").Split(',')) Attach(part.Trim(), defaultAction);
            }
            catch
            {
                // Nobody else can: the caller gets no socket.
                Close();
                throw;
            }
        }

        /// <summary>
        /// A message can be received. Raised by <see cref="Poll()"/> and by a <see cref="NetMQPoller"/>.
        /// </summary>
        public event EventHandler<NetMQSocketEventArgs> ReceiveReady
        {
            add { receiveReady += value; EventsChanged?.Invoke(); }
            remove { receiveReady -= value; EventsChanged?.Invoke(); }
        }

        /// <summary>A message can be sent. Raised by <see cref="Poll()"/> and by a <see cref="NetMQPoller"/>.</summary>
        public event EventHandler<NetMQSocketEventArgs> SendReady
        {
            add { sendReady += value; EventsChanged?.Invoke(); }
            remove { sendReady -= value; EventsChanged?.Invoke(); }
        }

        internal event Action? EventsChanged;

        /// <summary>The settings.</summary>
        public SocketOptions Options { get; }

        /// <summary>True once the socket was disposed.</summary>
        public bool IsDisposed => closed != 0;

        /// <summary>True if a message can be received now.</summary>
        public bool HasIn => ((PollEvents)GetInt(Option.Events)).HasIn();

        /// <summary>True if a message can be sent now.</summary>
        public bool HasOut => ((PollEvents)GetInt(Option.Events)).HasOut();

        NetMQSocket ISocketPollable.Socket => this;

        internal ZmqSocketType Type => type;

        internal string? LastEndpoint { get; private set; }

        /// <summary>True if further frames of the message follow the one received last.</summary>
        internal bool FrameHasMore { get; private set; }

        /// <summary>The frame received last, in libzmq's memory: valid until <see cref="DropFrame"/>.</summary>
        internal ReadOnlySpan<byte> Frame => new ReadOnlySpan<byte>(native.Data(message), frameSize);

        internal PollEvents WantedEvents
            => (receiveReady == null ? 0 : PollEvents.PollIn) | (sendReady == null ? 0 : PollEvents.PollOut);

        /// <summary>Listens at an address.</summary>
        public void Bind(string address)
        {
            CheckOpen();
            Endpoint.Split(address, out var protocol, out var rest);
            Endpoint.CheckProtocol(protocol, type);
            if (protocol == "inproc")
            {
                Offer(address);
                Call(native.Bind, address);
                LastEndpoint = address;
                return;
            }
            Call(native.Bind, protocol == "tcp" ? "tcp://" + Endpoint.ResolveTcp(rest, Options.IPv4Only) : address);
            LastEndpoint = Encoding.UTF8.GetString(GetBytes(Option.LastEndpoint)).TrimEnd('\0');
            if (protocol == "tcp") address = $"tcp://{rest.Substring(0, rest.IndexOf(':'))}:{Port(LastEndpoint)}";
            endpoints[address] = LastEndpoint;
        }

        /// <summary>Listens at a free port, and returns it. The address has no port: <c>tcp://127.0.0.1</c>.</summary>
        public int BindRandomPort(string address)
        {
            CheckOpen();
            Endpoint.Split(address, out var protocol, out _);
            if (protocol != "tcp") throw new ProtocolNotSupportedException("Address must use the TCP protocol.");
            Bind(address + ":0");
            return int.Parse(Port(LastEndpoint!), CultureInfo.InvariantCulture);
        }

        /// <summary>Connects to an address, now or as soon as somebody listens there.</summary>
        public void Connect(string address)
        {
            CheckOpen();
            Endpoint.Split(address, out var protocol, out var rest);
            Endpoint.CheckProtocol(protocol, type);
            if (protocol == "inproc" && context.OwnerOf(address) == null) throw new EndpointNotFoundException();
            var resolved = protocol == "tcp" ? "tcp://" + Endpoint.ResolveTcp(rest, Options.IPv4Only) : address;
            Call(native.Connect, resolved);
            LastEndpoint = endpoints[address] = resolved;
        }

        /// <summary>Undoes <see cref="Connect"/>.</summary>
        public void Disconnect(string address)
        {
            CheckOpen();
            if (address == null) throw new ArgumentNullException(nameof(address));
            Endpoint.Split(address, out var protocol, out _);
            Endpoint.CheckProtocol(protocol, type);
            if (!endpoints.TryGetValue(address, out var resolved))
            {
                if (protocol != "inproc" || context.OwnerOf(address) != this)
                {
                    throw new EndpointNotFoundException("Endpoint was not found and cannot be disconnected");
                }
                context.Withdraw(this, address);
                resolved = address;
            }
            endpoints.Remove(address);
            Call(native.Disconnect, resolved);
        }

        /// <summary>Undoes <see cref="Bind"/>. For port 0 or * the address has the real port.</summary>
        public void Unbind(string address) => Disconnect(address);

        /// <summary>
        /// Sends one frame and leaves the Msg empty, or returns false if that was not possible in time.
        /// </summary>
        public virtual bool TrySend(ref Msg msg, TimeSpan timeout, bool more)
        {
            if (!msg.IsInitialised) throw new FaultException("SocketBase.Send passed an uninitialised Msg.");
            if (!TrySendBytes(msg.Slice(), timeout, more)) return false;
            msg.Close();
            msg.InitEmpty();
            return true;
        }

        /// <summary>Receives one frame into the Msg, or empties it and returns false if none came in time.</summary>
        public virtual bool TryReceive(ref Msg msg, TimeSpan timeout)
        {
            if (!msg.IsInitialised) throw new FaultException("SocketBase.Recv passed an uninitialised Msg.");
            Enter();
            try
            {
                var received = TryReceiveFrame(timeout);
                msg.Close();
                if (!received)
                {
                    msg.InitEmpty();
                    return false;
                }
                msg.InitPool(frameSize);
                Frame.CopyTo(msg.Slice());
                if (FrameHasMore) msg.SetFlags(MsgFlags.More);
                DropFrame();
                return true;
            }
            finally
            {
                Leave();
            }
        }

        internal virtual bool TrySendBytes(ReadOnlySpan<byte> data, TimeSpan timeout, bool more)
        {
            var socket = Enter();
            try
            {
                // After its first frame a message never has to wait. And where the connection ends in the middle of it,
                // libzmq calls what it drops sent if it was told to wait, after which REQ refuses to receive.
                var limit = amid ? 0 : Milliseconds(timeout);
                amid = false;
                var start = limit > 0 ? Stopwatch.GetTimestamp() : 0;
                var wait = OneWait(limit);
                while (true)
                {
                    if (wait != 0 && wait != sendLimit) SetInt(Option.SendTimeout, sendLimit = wait);
                    int sent;
                    // Not `fixed (… = data)`: Mono 6 lacks the method that the compiler would call.
                    fixed (byte* bytes = &MemoryMarshal.GetReference(data))
                    {
                        sent = native.Send(socket, bytes, (IntPtr)data.Length,
                            (more ? Native.SendMore : 0) | (wait == 0 ? Native.DontWait : 0));
                    }
                    if (sent >= 0)
                    {
                        amid = more;
                        return true;
                    }
                    if (IsOver(native.Error, sending: true, limit, start, ref wait)) return false;
                }
            }
            finally
            {
                Leave();
            }
        }

        /// <summary>
        /// Receives into <see cref="Frame"/>. The caller has entered, and leaves when it has read that.
        /// </summary>
        internal virtual bool TryReceiveFrame(TimeSpan timeout)
        {
            var limit = Milliseconds(timeout);
            var start = limit > 0 ? Stopwatch.GetTimestamp() : 0;
            var wait = OneWait(limit);
            while (true)
            {
                if (wait != 0 && wait != receiveLimit) SetInt(Option.ReceiveTimeout, receiveLimit = wait);
                frameSize = native.Receive(message, handle, wait == 0 ? Native.DontWait : 0);
                if (frameSize >= 0)
                {
                    FrameHasMore = native.HasMore(message) != 0;
                    return true;
                }
                frameSize = 0;
                if (IsOver(native.Error, sending: false, limit, start, ref wait)) return false;
            }
        }

        internal void DropFrame()
        {
            if (frameSize <= InlineSize) return;
            native.CloseMessage(message);
            native.InitMessage(message);
            frameSize = 0;
        }

        /// <summary>
        /// The handle, which stays valid until <see cref="Leave"/>, also when another thread disposes the socket:
        /// libzmq ends the process when a socket is closed while it is in use.
        /// </summary>
        internal IntPtr Enter()
        {
            CheckOpen();
            Interlocked.Increment(ref users);
            if (closed == 0) return handle;
            Leave();
            throw Disposed();
        }

        /// <summary>The last one to leave a disposed socket ends it.</summary>
        internal void Leave()
        {
            if (Interlocked.Decrement(ref users) != 0 || Interlocked.Exchange(ref ended, 1) != 0) return;
            native.CloseMessage(message);
            Marshal.FreeHGlobal((IntPtr)message);
            lock (endpoints) context.CloseSocket(this, handle, Options.Lingers);
        }

        internal void CheckOpen()
        {
            if (closed != 0) throw Disposed();
        }

        /// <summary>Waits until the socket is ready and raises its events.</summary>
        public void Poll() => Poll(SendReceiveConstants.InfiniteTimeout);

        /// <summary>Waits until the socket is ready and raises its events; false if it was not ready in time.</summary>
        public bool Poll(TimeSpan timeout)
        {
            var events = Poll(WantedEvents, timeout);
            RaiseEvents(this, events);
            return events != PollEvents.None;
        }

        /// <summary>Waits until the socket is ready, without events.</summary>
        public PollEvents Poll(PollEvents pollEvents, TimeSpan timeout)
        {
            pollSet ??= new PollSet(new[] { this });
            pollSet.Want(0, pollEvents);
            pollSet.Wait(Milliseconds(timeout));
            return pollSet.Ready(0);
        }

        internal void RaiseEvents(object sender, PollEvents events)
        {
            if (closed != 0) return;
            eventArgs.Init(events);
            if (events.HasIn()) receiveReady?.Invoke(sender, eventArgs);
            if (events.HasOut()) sendReady?.Invoke(sender, eventArgs);
        }

        /// <summary>Reports what happens to the socket at an in-process address; see NetMQMonitor.</summary>
        public void Monitor(string endpoint, SocketEvents events = SocketEvents.All)
        {
            if (endpoint == null) throw new ArgumentNullException(nameof(endpoint));
            if (endpoint.Length == 0) throw new ArgumentException("Cannot be empty.", nameof(endpoint));
            CheckOpen();
            Endpoint.Split(endpoint, out var protocol, out _);
            Endpoint.CheckProtocol(protocol, type);
            if (protocol != "inproc")
            {
                throw new ProtocolNotSupportedException($"In SocketBase.Monitor({endpoint},), protocol must be inproc");
            }
            Offer(endpoint);
            monitorEndpoint = endpoint;
            monitorEvents = events;
        }

        /// <summary>
        /// Begins or ends the reports, from any thread. Without a reader libzmq's I/O thread would wait for one, and
        /// all communication with it; so the reports begin when the reader is ready, and end before it goes.
        /// </summary>
        internal void Report(bool wanted)
        {
            lock (endpoints)
            {
                if (closed != 0) return;
                fixed (byte* text = wanted ? Native.CString(monitorEndpoint!) : null)
                {
                    Check(native.Monitor(handle, text, (int)monitorEvents));
                }
            }
        }

        internal NetMQSocket? MonitoredAt(string endpoint) => context.OwnerOf(endpoint);

        /// <summary>Ends the socket. A thread that waits on it gets an <see cref="ObjectDisposedException"/>.</summary>
        public void Close()
        {
            if (Interlocked.Exchange(ref closed, 1) == 0) Leave();
        }

        /// <inheritdoc/>
        public void Dispose()
        {
            Dispose(true);
            GC.SuppressFinalize(this);
        }

        /// <summary>Ends the socket.</summary>
        protected virtual void Dispose(bool disposing)
        {
            if (disposing) Close();
        }

        internal int GetInt(Option option)
        {
            int value;
            Get(option, &value, sizeof(int));
            return value;
        }

        internal void SetInt(Option option, int value) => Set(option, &value, sizeof(int));

        internal long GetLong(Option option)
        {
            long value;
            Get(option, &value, sizeof(long));
            return value;
        }

        internal void SetLong(Option option, long value) => Set(option, &value, sizeof(long));

        internal byte[] GetBytes(Option option, int limit = 1024)
        {
            var value = stackalloc byte[limit];
            return new ReadOnlySpan<byte>(value, Get(option, value, limit)).ToArray();
        }

        internal void SetBytes(Option option, byte[]? value)
        {
            fixed (byte* bytes = value) Set(option, bytes, value?.Length ?? 0);
        }

        private int Get(Option option, void* value, int limit)
        {
            var size = (IntPtr)limit;
            var socket = Enter();
            try
            {
                Check(native.GetOption(socket, option, value, &size));
            }
            finally
            {
                Leave();
            }
            return (int)size;
        }

        private void Set(Option option, void* value, int size)
        {
            var socket = Enter();
            try
            {
                Check(native.SetOption(socket, option, value, (IntPtr)size));
            }
            finally
            {
                Leave();
            }
        }

        /// <summary>Whole milliseconds: 0 only for no waiting at all, -1 for ever.</summary>
        internal static int Milliseconds(TimeSpan timeout)
        {
            if (timeout == TimeSpan.Zero) return 0;
            var wanted = Math.Ceiling(timeout.TotalMilliseconds);
            return wanted < 0 || wanted > int.MaxValue ? -1 : (int)wanted;
        }

        internal static int TimeLeft(int limit, long start)
            => Math.Max(0, limit - (int)((Stopwatch.GetTimestamp() - start) * 1000 / Stopwatch.Frequency));

        /// <summary>How long to wait inside libzmq before the next look around; -1 milliseconds are for ever.</summary>
        internal static int OneWait(int left) => left < 0 ? Slice : Math.Min(left, Slice);

        private void Attach(string address, DefaultAction action)
        {
            if (address.Length == 0) return;
            var bare = address[0] == '@' || address[0] == '>' ? address.Substring(1) : address;
            if (address[0] == '@' || (address[0] != '>' && action == DefaultAction.Bind)) Bind(bare);
            else Connect(bare);
        }

        private static string Port(string endpoint) => endpoint.Substring(endpoint.LastIndexOf(':') + 1);

        private void Offer(string address)
        {
            if (context.Offer(address, this)) return;
            throw new AddressAlreadyInUseException($"Cannot bind address ( {address} ) - already in use.");
        }

        private void Call(Native.EndpointCall call, string endpoint)
        {
            var socket = Enter();
            try
            {
                fixed (byte* text = Native.CString(endpoint)) Check(call(socket, text));
            }
            finally
            {
                Leave();
            }
        }

        private void Check(int result)
        {
            if (result < 0) throw Failure(native.Error);
        }

        /// <summary>True if the time of a call is over; false if only one wait was, or a signal cut it short.</summary>
        private bool IsOver(int error, bool sending, int limit, long start, ref int wait)
        {
            if (error != Native.Interrupted && error != Native.Again)
            {
                throw Native.ToErrorCode(error) switch
                {
                    ErrorCode.FiniteStateMachine => new FiniteStateMachineException(null, OutOfTurn(sending)),
                    ErrorCode.HostUnreachable => new HostUnreachableException(null, "In Router.XSend"),
                    _ => Failure(error),
                };
            }
            CheckOpen();
            if (limit > 0) wait = OneWait(TimeLeft(limit, start));
            // Zero is also the wait of a call that has no time at all.
            return error == Native.Again && wait == 0;
        }

        private Exception Disposed() => new ObjectDisposedException(GetType().FullName);

        private string OutOfTurn(bool sending) => (type, sending) switch
        {
            (ZmqSocketType.Req, true) => "Req.XSend - cannot send another request",
            (ZmqSocketType.Req, false) => "Req.XRecv - cannot receive another reply",
            (_, true) => "Rep.XSend - cannot send another reply",
            (_, false) => "Rep.XRecv - cannot receive another request",
        };

        internal static Exception Failure(int error) => Native.ToErrorCode(error) switch
        {
            ErrorCode.ContextTerminated => new TerminatingException("CheckContextTerminated - yes, is terminated."),
            // NetMQ passes the system's exception on inside one whose own text says nothing.
            ErrorCode.AddressAlreadyInUse => NetMQException.Create(ErrorCode.AddressAlreadyInUse,
                new SocketException((int)SocketError.AddressAlreadyInUse)),
            var code => NetMQException.Create(Native.Instance.ErrorText(error), code),
        };
    }
}
