// Monitors: what happens to connections.
using System;
using System.Collections.Concurrent;
using System.Linq;
using System.Net;
using System.Net.Sockets;
using System.Threading;
using System.Threading.Tasks;
using NetMQ;
using NetMQ.Monitoring;
using NetMQ.Sockets;

namespace NetMQExample.Conformance
{
    internal static class Monitoring
    {
        internal static void Run()
        {
            OwnThread();
            InPoller();
            Unread();
            AmidReports();
            using var socket = new PairSocket();
            Say.Throws("monitor at no address", () => socket.Monitor(""));
            Say.Throws("monitor at null", () => socket.Monitor(null!));
            Say.Throws("monitor over TCP", () => socket.Monitor("tcp://127.0.0.1:0"));
            Say.Throws("monitor without a protocol", () => socket.Monitor("nowhere"));
            Say.That("all events", (int)SocketEvents.All);
        }

        private static void OwnThread()
        {
            var seen = new ConcurrentDictionary<SocketEvents, string>();
            using var client = new DealerSocket();
            client.Options.ReconnectInterval = TimeSpan.FromMilliseconds(20);
            using var monitor = new NetMQMonitor(client, "inproc://client-events", SocketEvents.All);
            monitor.Timeout = TimeSpan.FromMilliseconds(50);
            Say.That("monitor", monitor.Endpoint, monitor.IsRunning);
            monitor.EventReceived += (_, e) => seen.TryAdd(e.SocketEvent, e.Address);
            var connected = 0;
            var disconnected = 0;
            monitor.Connected += (sender, e) =>
            {
                if (sender == monitor && e.Monitor == monitor && e.SocketEvent == SocketEvents.Connected) connected++;
            };
            monitor.Disconnected += (_, _) => disconnected++;
            var running = monitor.StartAsync();
            Say.That("watches", Say.Soon(() => monitor.IsRunning));
            Say.Throws("start again", monitor.Start);
            string address;
            using (var server = new RouterSocket("@tcp://127.0.0.1:0"))
            {
                address = server.Options.LastEndpoint!;
                client.Connect(address);
                Say.That("connected", Say.Soon(() => connected == 1));
                Say.That("its address", seen[SocketEvents.Connected] == address);
            }
            Say.That("disconnected", Say.Soon(() => disconnected == 1));
            using (var server = new RouterSocket())
            {
                Say.That("bound again", Say.Soon(() => Say.Thrown(() => server.Bind(address)) == null));
                Say.That("connected again", Say.Soon(() => connected == 2));
            }
            monitor.Stop();
            Say.That("stopped", running.Wait(Say.Timeout), monitor.IsRunning);
        }

        /// <summary>Reports that nobody reads must not hold up the connection they are about.</summary>
        private static void Unread()
        {
            using var server = new ResponseSocket("@tcp://127.0.0.1:0");
            using var client = new RequestSocket();
            var monitor = new NetMQMonitor(client, "inproc://unread", SocketEvents.All);
            client.Connect(server.Options.LastEndpoint!);
            client.SendFrame("nobody watches");
            Say.That("before the monitor started", Say.Received(server));
            server.SendFrame("ok");
            Say.That("reply", Say.Received(client));
            var running = monitor.StartAsync();
            Say.That("watches", Say.Soon(() => monitor.IsRunning));
            monitor.Stop();
            running.Wait(Say.Timeout);
            client.Disconnect(server.Options.LastEndpoint!);
            client.Connect(server.Options.LastEndpoint!);
            client.SendFrame("nobody watches");
            Say.That("after the monitor stopped", Say.Received(server));
            server.SendFrame("ok");
            Say.That("reply", Say.Received(client));
            monitor.Dispose();
            client.Disconnect(server.Options.LastEndpoint!);
            client.Connect(server.Options.LastEndpoint!);
            client.SendFrame("nobody watches");
            Say.That("after the monitor was disposed", Say.Received(server));
        }

        private static void InPoller()
        {
            var seen = new ConcurrentQueue<SocketEvents>();
            using var server = new RouterSocket();
            using var poller = new NetMQPoller();
            using var monitor = new NetMQMonitor(server, "inproc://server-events",
                SocketEvents.Listening | SocketEvents.Accepted | SocketEvents.Disconnected);
            monitor.Listening += (_, e) => seen.Enqueue(e.SocketEvent);
            monitor.Accepted += (_, e) => seen.Enqueue(e.SocketEvent);
            monitor.Disconnected += (_, e) => seen.Enqueue(e.SocketEvent);
            monitor.AttachToPoller(poller);
            Say.Throws("attach twice", () => monitor.AttachToPoller(poller));
            Say.Throws("start when attached", monitor.Start);
            Say.Throws("stop when attached", monitor.Stop);
            poller.RunAsync();
            server.Bind("tcp://127.0.0.1:0");
            using (var client = new DealerSocket(server.Options.LastEndpoint))
            {
                client.SendFrame("x");
                Say.That("server got", Say.Received(server).EndsWith("|x", StringComparison.Ordinal));
                Say.That("accepted", Say.Soon(() => seen.Contains(SocketEvents.Accepted)));
            }
            Say.That("left", Say.Soon(() => seen.Contains(SocketEvents.Disconnected)));
            Say.That("in order", string.Join(",", seen));
            poller.Stop();
        }

        /// <summary>Who ends a monitor while connections come and go is not held up.</summary>
        private static void AmidReports()
        {
            var cuts = 0;
            var listener = new TcpListener(IPAddress.Loopback, 0);
            listener.Start();
            using var client = new DealerSocket();
            client.Options.ReconnectInterval = TimeSpan.FromMilliseconds(1);
            var monitor = new NetMQMonitor(client, "inproc://amid", SocketEvents.Disconnected);
            monitor.AttachToPoller(new SlowPoller(() => CutMore(5)));
            client.Connect($"tcp://{listener.LocalEndpoint}");
            _ = Task.Run(async () =>
            {
                while (true)
                {
                    (await listener.AcceptSocketAsync().ConfigureAwait(false)).Dispose();
                    Interlocked.Increment(ref cuts);
                }
            });
            Say.That("connections come and go", CutMore(5));
            Say.That("ended meanwhile", Task.Run(monitor.Dispose).Wait(Say.Timeout));
            Say.That("and they still do", CutMore(5));
            listener.Stop();

            bool CutMore(int number)
            {
                var enough = Volatile.Read(ref cuts) + number;
                return Say.Soon(() => Volatile.Read(ref cuts) >= enough);
            }
        }

        /// <summary>Between the end of a socket and that of its reports, other threads are at work.</summary>
        private sealed class SlowPoller : INetMQPoller
        {
            private readonly Func<bool> pause;

            internal SlowPoller(Func<bool> pause) => this.pause = pause;

            public bool IsRunning => false;

            public void RemoveAndDispose<T>(T socket) where T : ISocketPollable, IDisposable
            {
                socket.Dispose();
                pause();
            }

            public void Add(ISocketPollable socket) { }
            public void Remove(ISocketPollable socket) { }
            public void Run() { }
            public void RunAsync() { }
            public void Stop() { }
            public void StopAsync() { }
            public void Dispose() { }
        }
    }
}
