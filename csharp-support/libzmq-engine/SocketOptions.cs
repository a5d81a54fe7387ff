// A socket's settings: NetMQ's names and units over libzmq's options.
using System;
using System.Diagnostics.CodeAnalysis;

namespace NetMQ
{
    /// <summary>The settings of one socket. Most take effect at the next Bind or Connect.</summary>
    public class SocketOptions
    {
        private readonly NetMQSocket socket;
        private TimeSpan keepaliveIdle = TimeSpan.FromMilliseconds(-1);
        private TimeSpan keepaliveInterval = TimeSpan.FromMilliseconds(-1);

        /// <summary>For one socket.</summary>
        public SocketOptions(NetMQSocket socket) => this.socket = socket;

        internal bool Lingers { get; private set; }

        /// <summary>Which I/O threads may serve the socket, one bit each; 0 for all.</summary>
        public long Affinity
        {
            get => socket.GetLong(Option.Affinity);
            set => socket.SetLong(Option.Affinity, value);
        }

        /// <summary>The name under which a ROUTER knows this socket: 1 to 255 bytes.</summary>
        [DisallowNull]
        public byte[]? Identity
        {
            get
            {
                var value = socket.GetBytes(Option.RoutingId);
                return value.Length == 0 ? null : value;
            }
            set => socket.SetBytes(Option.RoutingId, value);
        }

        /// <summary>The size of the system's send buffer; 0 for its default.</summary>
        public int SendBuffer
        {
            get => Math.Max(0, socket.GetInt(Option.SendBuffer));
            set => socket.SetInt(Option.SendBuffer, value == 0 ? -1 : value);
        }

        /// <summary>The size of the system's receive buffer; 0 for its default.</summary>
        public int ReceiveBuffer
        {
            get => Math.Max(0, socket.GetInt(Option.ReceiveBuffer));
            set => socket.SetInt(Option.ReceiveBuffer, value == 0 ? -1 : value);
        }

        /// <summary>True if further frames follow the one received last.</summary>
        public bool ReceiveMore => socket.FrameHasMore;

        /// <summary>How long a disposed socket keeps trying to send what it holds; -1 ms for ever.</summary>
        public TimeSpan Linger
        {
            get => GetTime(Option.Linger);
            set
            {
                SetTime(Option.Linger, value);
                Lingers = value != TimeSpan.Zero;
            }
        }

        /// <summary>The pause before connecting again; -1 ms for never.</summary>
        public TimeSpan ReconnectInterval
        {
            get => GetTime(Option.ReconnectInterval);
            set => SetTime(Option.ReconnectInterval, value);
        }

        /// <summary>The longest pause before connecting again, if it is to grow; 0 if not.</summary>
        public TimeSpan ReconnectIntervalMax
        {
            get => GetTime(Option.ReconnectIntervalMax);
            set => SetTime(Option.ReconnectIntervalMax, value);
        }

        /// <summary>How many peers may wait for being accepted.</summary>
        public int Backlog
        {
            get => socket.GetInt(Option.Backlog);
            set => socket.SetInt(Option.Backlog, value);
        }

        /// <summary>The largest frame to accept; a peer that sends a larger one is cut off. -1 for any.</summary>
        public long MaxMsgSize
        {
            get => socket.GetLong(Option.MaxMsgSize);
            set => socket.SetLong(Option.MaxMsgSize, value);
        }

        /// <summary>How many messages may wait to be sent to each peer; 0 for any number.</summary>
        public int SendHighWatermark
        {
            get => socket.GetInt(Option.SendHighWatermark);
            set => socket.SetInt(Option.SendHighWatermark, value);
        }

        /// <summary>How many messages of each peer may wait to be received; 0 for any number.</summary>
        public int ReceiveHighWatermark
        {
            get => socket.GetInt(Option.ReceiveHighWatermark);
            set => socket.SetInt(Option.ReceiveHighWatermark, value);
        }

        /// <summary>True to leave IPv6 alone.</summary>
        public bool IPv4Only
        {
            get => socket.GetInt(Option.IPv6) == 0;
            set => socket.SetInt(Option.IPv6, value ? 0 : 1);
        }

        /// <summary>What the last Bind or Connect led to, with the real port.</summary>
        public string? LastEndpoint => socket.LastEndpoint;

        /// <summary>
        /// True to throw <see cref="HostUnreachableException"/> for an unknown identity, not to drop.
        /// </summary>
        public bool RouterMandatory
        {
            set => socket.SetInt(Option.RouterMandatory, value ? 1 : 0);
        }

        /// <summary>True to give an identity to the peer who claimed it last.</summary>
        public bool RouterHandover
        {
            set => socket.SetInt(Option.RouterHandover, value ? 1 : 0);
        }

        /// <summary>True to pass on each subscription, also one that is known already.</summary>
        public bool XPubVerbose
        {
            set => socket.SetInt(Option.XPubVerbose, value ? 1 : 0);
        }

        /// <summary>True to let TCP ask whether the peer is still there.</summary>
        public bool TcpKeepalive
        {
            get => socket.GetInt(Option.TcpKeepalive) == 1;
            set => socket.SetInt(Option.TcpKeepalive, value ? 1 : 0);
        }

        /// <summary>How many of these questions may stay unanswered.</summary>
        public int TcpKeepaliveCnt
        {
            get => socket.GetInt(Option.TcpKeepaliveCount);
            set => socket.SetInt(Option.TcpKeepaliveCount, value);
        }

        /// <summary>How long a connection must be idle before the first question.</summary>
        public TimeSpan TcpKeepaliveIdle
        {
            get => keepaliveIdle;
            set => SetSeconds(Option.TcpKeepaliveIdle, keepaliveIdle = value);
        }

        /// <summary>The time between two questions.</summary>
        public TimeSpan TcpKeepaliveInterval
        {
            get => keepaliveInterval;
            set => SetSeconds(Option.TcpKeepaliveInterval, keepaliveInterval = value);
        }

        /// <summary>True to queue messages only for peers that are connected.</summary>
        public bool DelayAttachOnConnect
        {
            get => socket.GetInt(Option.Immediate) == 1;
            set => socket.SetInt(Option.Immediate, value ? 1 : 0);
        }

        /// <summary>How long the peer is to wait for our sign of life.</summary>
        public TimeSpan HeartbeatTtl
        {
            get => GetTime(Option.HeartbeatTtl);
            set => SetTime(Option.HeartbeatTtl, value);
        }

        /// <summary>The time between two questions whether the peer lives; 0 for none.</summary>
        public TimeSpan HeartbeatInterval
        {
            get => GetTime(Option.HeartbeatInterval);
            set => SetTime(Option.HeartbeatInterval, value);
        }

        /// <summary>How long to wait for the answer; the interval, unless set.</summary>
        public TimeSpan HeartbeatTimeout
        {
            get
            {
                var own = socket.GetInt(Option.HeartbeatTimeout);
                return own == -1 ? HeartbeatInterval : TimeSpan.FromMilliseconds(own);
            }
            set => SetTime(Option.HeartbeatTimeout, value);
        }

        /// <summary>True to let a REQ socket send again without having the reply. It cannot be read back.</summary>
        public bool Relaxed
        {
            get => throw new InvalidException("GetSocketOption called with invalid ZmqSocketOption of Relaxed");
            set => SetRequest(Option.RequestRelaxed, value);
        }

        /// <summary>
        /// True to number requests, so that a late reply is not taken for the present one. It cannot be read back.
        /// </summary>
        public bool Correlate
        {
            get => throw new InvalidException("GetSocketOption called with invalid ZmqSocketOption of Correlate");
            set => SetRequest(Option.RequestCorrelate, value);
        }

        /// <summary>True for the side of an encrypted connection that has the known key.</summary>
        public bool CurveServer
        {
            get => socket.GetInt(Option.CurveServer) == 1;
            set => socket.SetInt(Option.CurveServer, value ? 1 : 0);
        }

        /// <summary>The socket's own pair of keys.</summary>
        public NetMQCertificate CurveCertificate
        {
            set
            {
                if (value.SecretKey == null)
                {
                    throw new ArgumentException("NetMQCertificate must have a secret key", nameof(value));
                }
                socket.SetBytes(Option.CurveSecretKey, value.SecretKey);
                socket.SetBytes(Option.CurvePublicKey, value.PublicKey);
            }
        }

        /// <summary>The server's public key, 32 bytes.</summary>
        [DisallowNull]
        public byte[]? CurveServerKey
        {
            get => socket.GetBytes(Option.CurveServerKey, 32);
            set => socket.SetBytes(Option.CurveServerKey, value);
        }

        /// <summary>The server's public key.</summary>
        public NetMQCertificate CurveServerCertificate
        {
            set => CurveServerKey = value.PublicKey;
        }

        private TimeSpan GetTime(Option option) => TimeSpan.FromMilliseconds(socket.GetInt(option));

        private void SetTime(Option option, TimeSpan value) => socket.SetInt(option, (int)value.TotalMilliseconds);

        // libzmq counts these in seconds.
        private void SetSeconds(Option option, TimeSpan value)
            => socket.SetInt(option, value < TimeSpan.Zero ? -1 : (int)Math.Ceiling(value.TotalSeconds));

        // Other sockets take these options in NetMQ, and ignore them.
        private void SetRequest(Option option, bool value)
        {
            if (socket.Type == ZmqSocketType.Req) socket.SetInt(option, value ? 1 : 0);
        }
    }
}
