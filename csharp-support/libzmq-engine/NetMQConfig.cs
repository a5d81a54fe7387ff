// The process-wide part: one libzmq context, made by the first socket and ended by NetMQConfig.Cleanup.
using System;
using System.Collections.Generic;
using System.Threading;

namespace NetMQ
{
    /// <summary>What all sockets of the process share.</summary>
    public static class NetMQConfig
    {
        private static readonly object sync = new object();
        private static TimeSpan linger = TimeSpan.Zero;
        private static int threadPoolSize = 1;
        private static int maxSockets = 1024;
        private static Context? context;

        internal static Context Context
        {
            get
            {
                lock (sync) return context ??= new Context(threadPoolSize, maxSockets);
            }
        }

        /// <summary>
        /// How long a new socket keeps trying to send what it holds when it is disposed. Not at all, at first.
        /// </summary>
        public static TimeSpan Linger
        {
            get { lock (sync) return linger; }
            set { lock (sync) linger = value; }
        }

        /// <summary>The number of I/O threads, used by the next context.</summary>
        public static int ThreadPoolSize
        {
            get { lock (sync) return threadPoolSize; }
            set { lock (sync) threadPoolSize = value; }
        }

        /// <summary>How many sockets there may be at once, used by the next context.</summary>
        public static int MaxSockets
        {
            get { lock (sync) return maxSockets; }
            set { lock (sync) maxSockets = value; }
        }

        /// <summary>
        /// Ends all communication: whoever waits on a socket gets a <see cref="TerminatingException"/>. It returns when
        /// every socket is disposed, or at once with <paramref name="block"/> false. The next socket starts afresh.
        /// </summary>
        public static void Cleanup(bool block = true)
        {
            Context? old;
            lock (sync) (old, context) = (context, null);
            // Without the lock, which a new socket takes: it starts afresh, also while this waits.
            old?.Terminate(block);
        }
    }

    /// <summary>A libzmq context, and what NetMQ's context knows beyond it.</summary>
    internal sealed class Context
    {
        private readonly Dictionary<string, NetMQSocket> inproc = new Dictionary<string, NetMQSocket>();
        private readonly IntPtr handle;
        private int open;
        private bool ending;
        private bool freed;
        private bool lingers;

        internal Context(int threads, int sockets)
        {
            Native = Native.Instance;
            handle = Native.NewContext();
            Native.SetContext(handle, Native.IOThreads, threads);
            Native.SetContext(handle, Native.MaxSockets, sockets);
        }

        internal Native Native { get; }

        internal IntPtr NewSocket(ZmqSocketType type)
        {
            lock (inproc)
            {
                // An ending context may be freed already; libzmq must not see it again.
                var socket = ending ? IntPtr.Zero : Native.NewSocket(handle, (int)type);
                if (socket != IntPtr.Zero)
                {
                    open++;
                    return socket;
                }
                var code = ending ? ErrorCode.ContextTerminated : Native.ToErrorCode(Native.Error);
                if (code != ErrorCode.ContextTerminated) throw NetMQException.Create(code);
                throw new TerminatingException(
                    $"Ctx.CreateSocket({type}), cannot create new socket while terminating.");
            }
        }

        internal void CloseSocket(NetMQSocket owner, IntPtr socket, bool lingering)
        {
            bool last;
            lock (inproc)
            {
                Withdraw(owner, null);
                Native.Close(socket);
                lingers |= lingering;
                last = --open == 0 && ending;
            }
            if (last) Free();
        }

        internal void Terminate(bool block)
        {
            var last = false;
            lock (inproc)
            {
                if (!ending)
                {
                    ending = true;
                    Native.ShutdownContext(handle);
                    last = open == 0;
                }
            }
            // With sockets left, the last of them to be disposed frees the context.
            if (last) Free();
            lock (inproc)
            {
                while (block && !freed) Monitor.Wait(inproc);
            }
        }

        /// <summary>
        /// Notes an in-process name. libzmq lets a socket connect to one that nobody has; NetMQ does not.
        /// </summary>
        internal bool Offer(string address, NetMQSocket owner)
        {
            lock (inproc) return inproc.TryAdd(address, owner);
        }

        internal NetMQSocket? OwnerOf(string address)
        {
            lock (inproc) return inproc.TryGetValue(address, out var owner) ? owner : null;
        }

        internal void Withdraw(NetMQSocket owner, string? address)
        {
            lock (inproc)
            {
                foreach (var name in new List<string>(inproc.Keys))
                {
                    if (inproc[name] == owner && (address ?? name) == name) inproc.Remove(name);
                }
            }
        }

        private void Free()
        {
            // Undelivered messages keep libzmq busy for their linger time; neither Dispose nor Cleanup(false) waits.
            if (lingers) new Thread(Destroy) { IsBackground = true, Name = "NetMQ linger" }.Start();
            else Destroy();
        }

        private void Destroy()
        {
            while (Native.TerminateContext(handle) < 0 && Native.Error == Native.Interrupted) { }
            lock (inproc)
            {
                freed = true;
                Monitor.PulseAll(inproc);
            }
        }
    }
}
