// Passes messages between two sockets, both ways.
using System;
using System.Threading;

namespace NetMQ
{
    /// <summary>Connects a frontend and a backend, such as ROUTER and DEALER or XSUB and XPUB.</summary>
    public class Proxy
    {
        private readonly NetMQSocket frontend;
        private readonly NetMQSocket backend;
        private readonly NetMQSocket? controlIn;
        private readonly NetMQSocket? controlOut;
        private readonly INetMQPoller? external;
        private NetMQPoller? own;
        private int state;

        /// <summary>Sends a copy of what passes to a control socket for each direction.</summary>
        public Proxy(NetMQSocket frontend, NetMQSocket backend, NetMQSocket? controlIn, NetMQSocket? controlOut,
            INetMQPoller? poller = null)
        {
            this.frontend = frontend;
            this.backend = backend;
            this.controlIn = controlIn;
            this.controlOut = controlOut ?? controlIn;
            external = poller;
        }

        /// <summary>Sends a copy of what passes to a control socket, if there is one.</summary>
        public Proxy(NetMQSocket frontend, NetMQSocket backend, NetMQSocket? control = null,
            INetMQPoller? poller = null)
            : this(frontend, backend, control, null, poller) { }

        /// <summary>Works until <see cref="Stop"/>; with a poller of the program it returns at once.</summary>
        public void Start()
        {
            if (Interlocked.CompareExchange(ref state, 1, 0) != 0)
            {
                throw new InvalidOperationException("Proxy has already been started");
            }
            frontend.ReceiveReady += FromFrontend;
            backend.ReceiveReady += FromBackend;
            if (external != null)
            {
                state = 2;
                return;
            }
            own = new NetMQPoller { frontend, backend };
            state = 2;
            own.Run();
        }

        /// <summary>Ends <see cref="Start"/>.</summary>
        public void Stop()
        {
            if (Interlocked.CompareExchange(ref state, 3, 2) != 2)
            {
                throw new InvalidOperationException("Proxy has not been started");
            }
            own?.Stop();
            own?.Dispose();
            own = null;
            frontend.ReceiveReady -= FromFrontend;
            backend.ReceiveReady -= FromBackend;
            state = 0;
        }

        private void FromFrontend(object? sender, NetMQSocketEventArgs e) => Pass(frontend, backend, controlIn);

        private void FromBackend(object? sender, NetMQSocketEventArgs e) => Pass(backend, frontend, controlOut);

        private static void Pass(NetMQSocket from, NetMQSocket to, NetMQSocket? control)
        {
            var msg = new Msg();
            msg.InitEmpty();
            bool more;
            do
            {
                from.Receive(ref msg);
                more = msg.HasMore;
                control?.TrySendBytes(msg.Slice(), SendReceiveConstants.InfiniteTimeout, more);
                to.Send(ref msg, more);
            }
            while (more);
            msg.Close();
        }
    }
}
