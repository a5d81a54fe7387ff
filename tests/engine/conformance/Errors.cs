// What is refused, and with which exception.
using System;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample.Conformance
{
    internal static class Errors
    {
        internal static void Run()
        {
            Addresses();
            InUse();
            NotFound();
            Disposed();
            Exceptions();
        }

        private static void Addresses()
        {
            foreach (var address in new[]
            {
                "127.0.0.1:5555", "", "tcp", "tcp:/127.0.0.1:5555", "http://127.0.0.1:5555",
                "TCP://127.0.0.1:5555", "tcp://127.0.0.1", "tcp://127.0.0.1:", "tcp://127.0.0.1:port",
                    "tcp://127.0.0.1:-1",
                "tcp://127.0.0.1:65536", "tcp://127.0.0.1:99999999999", "tcp://no-such-host.invalid:5555", "tcp://",
                    "://",
            })
            {
                using var socket = new DealerSocket();
                Say.Throws($"connect {address}", () => socket.Connect(address));
                Say.Throws($"bind {address}", () => socket.Bind(address));
            }
            using var server = new DealerSocket();
            Say.Throws("connect null", () => server.Connect(null!));
            Say.Throws("bind null", () => server.Bind(null!));
            Say.ThrowsText("unknown protocol", () => server.Connect("http://127.0.0.1:5555"));
            Say.ThrowsText("no port", () => server.Connect("tcp://127.0.0.1"));
            Say.Throws("an address of another machine", () => server.Bind("tcp://192.0.2.1:0"));
            Say.Throws("random port, with a port", () => server.BindRandomPort("tcp://127.0.0.1:0:1"));
            Say.ThrowsText("random port, inproc", () => server.BindRandomPort("inproc://x"));
            Say.Throws("as a connection string", () => _ = new RequestSocket("127.0.0.1:5555"));
            server.Bind("tcp://*:0");
            Say.That("any address",
                server.Options.LastEndpoint!.StartsWith("tcp://0.0.0.0:", StringComparison.Ordinal));
            server.Bind("tcp://localhost:*");
            Say.That("a name", server.Options.LastEndpoint!.StartsWith("tcp://127.0.0.1:", StringComparison.Ordinal));
            Say.That("random port", server.BindRandomPort("tcp://127.0.0.1") > 0);
            using var client = new DealerSocket();
            client.Connect("tcp://localhost:5555");
            Say.That("a name, looked up", client.Options.LastEndpoint);
        }

        private static void InUse()
        {
            using var first = new ResponseSocket("@tcp://127.0.0.1:0");
            using var second = new ResponseSocket();
            Say.ThrowsText("the same port", () => second.Bind(first.Options.LastEndpoint!));
            var thrown = Say.Thrown(() => second.Bind(first.Options.LastEndpoint!));
            Say.That("error code", (thrown as NetMQException)?.ErrorCode);
            Say.That("cause", (thrown?.InnerException as System.Net.Sockets.SocketException)?.SocketErrorCode);
            Say.Throws("the same port twice", () => first.Bind(first.Options.LastEndpoint!));
            Say.Throws("by a constructor", () => _ = new ResponseSocket("@" + first.Options.LastEndpoint));
            second.Bind("tcp://127.0.0.1:0");
            Say.That("another port after that", second.Options.LastEndpoint != first.Options.LastEndpoint);
            first.Bind("inproc://in-use");
            Say.ThrowsText("the same name", () => second.Bind("inproc://in-use"));
            var address = first.Options.LastEndpoint;
            Say.That("last endpoint", address);
        }

        private static void NotFound()
        {
            using var socket = new DealerSocket();
            Say.Throws("an in-process name that nobody has", () => socket.Connect("inproc://nobody"));
            Say.ThrowsText("disconnect", () => socket.Disconnect("tcp://127.0.0.1:5555"));
            Say.ThrowsText("unbind", () => socket.Unbind("tcp://127.0.0.1:5555"));
            Say.ThrowsText("disconnect in-process", () => socket.Disconnect("inproc://nobody"));
            Say.Throws("disconnect null", () => socket.Disconnect(null!));
            Say.Throws("disconnect nonsense", () => socket.Disconnect("nonsense"));
            Say.Throws("disconnect an unknown protocol", () => socket.Disconnect("http://x"));
            socket.Connect("tcp://127.0.0.1:5555");
            socket.Disconnect("tcp://127.0.0.1:5555");
            Say.Throws("disconnect twice", () => socket.Disconnect("tcp://127.0.0.1:5555"));
            socket.Connect("tcp://localhost:5555");
            Say.Throws("disconnect by another spelling", () => socket.Disconnect("tcp://127.0.0.1:5555"));
            socket.Disconnect("tcp://localhost:5555");
            var port = socket.BindRandomPort("tcp://127.0.0.1");
            Say.Throws("unbind port 0", () => socket.Unbind("tcp://127.0.0.1:0"));
            socket.Unbind($"tcp://127.0.0.1:{port}");
            Say.Throws("unbind twice", () => socket.Unbind($"tcp://127.0.0.1:{port}"));
            using var heir = new DealerSocket();
            Say.That("the port is free again",
                Say.Soon(() => Say.Thrown(() => heir.Bind($"tcp://127.0.0.1:{port}")) == null));
            socket.Bind("inproc://mine");
            socket.Unbind("inproc://mine");
            Say.Throws("connect to a withdrawn name", () => heir.Connect("inproc://mine"));
            socket.Bind("inproc://mine");
            heir.Connect("inproc://mine");
            heir.Disconnect("inproc://mine");
            Say.That("the name can be used again", "yes");
        }

        private static void Disposed()
        {
            var socket = new RequestSocket();
            Say.That("disposed", socket.IsDisposed);
            socket.Dispose();
            socket.Dispose();
            socket.Close();
            Say.That("disposed", socket.IsDisposed);
            Say.Throws("bind", () => socket.Bind("tcp://127.0.0.1:0"));
            Say.Throws("random port", () => socket.BindRandomPort("tcp://127.0.0.1"));
            Say.Throws("connect", () => socket.Connect("tcp://127.0.0.1:5555"));
            Say.Throws("disconnect", () => socket.Disconnect("tcp://127.0.0.1:5555"));
            Say.Throws("unbind", () => socket.Unbind("tcp://127.0.0.1:5555"));
            Say.Throws("ready", () => _ = socket.HasIn);
            Say.Throws("get option", () => _ = socket.Options.Linger);
            Say.Throws("set option", () => socket.Options.Linger = TimeSpan.Zero);
            Say.Throws("monitor", () => socket.Monitor("inproc://gone"));
            var queue = new NetMQQueue<int>();
            queue.Dispose();
            queue.Dispose();
            Say.That("queue", queue.IsDisposed);
        }

        private static void Exceptions()
        {
            foreach (ErrorCode code in Enum.GetValues(typeof(ErrorCode)))
            {
                var thrown = NetMQException.Create("text", code);
                Say.That($"{code} {(int)code}", thrown.GetType().Name, thrown.ErrorCode == code, thrown.Message);
            }
            Say.That("no text", NetMQException.Create(ErrorCode.Invalid).Message);
            Say.That("no code", new NetMQException("text").ErrorCode);
            Say.That("cause", NetMQException.Create(ErrorCode.Fault, new Exception("cause")).InnerException?.Message);
        }
    }
}
