// The life of the process-wide context: Cleanup, with and without waiting, and starting afresh.
using System;
using System.Diagnostics;
using System.Threading;
using System.Threading.Tasks;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample.Conformance
{
    internal static class Lifecycle
    {
        internal static void Run()
        {
            NothingOpen();
            Rounds();
            BlockedReceiver();
            Blocking();
            NotBlocking();
            Unsent();
            Pollers();
            ManySockets();
        }

        private static string Exchange()
        {
            using var server = new ResponseSocket("@tcp://127.0.0.1:0");
            using var client = new RequestSocket(server.Options.LastEndpoint);
            client.SendFrame("Hello");
            var request = Say.Received(server);
            server.SendFrame("World");
            return $"{request} {Say.Received(client)}";
        }

        private static void NothingOpen()
        {
            NetMQConfig.Cleanup(false);
            NetMQConfig.Cleanup(false);
            NetMQConfig.Cleanup();
            Say.That("after cleaning up nothing", Exchange());
            var clock = Stopwatch.StartNew();
            NetMQConfig.Cleanup();
            Say.That("all disposed, so no waiting", clock.Elapsed < TimeSpan.FromSeconds(5));
        }

        private static void Rounds()
        {
            var good = 0;
            for (var i = 0; i < 20; i++)
            {
                if (Exchange() == "Hello World") good++;
                NetMQConfig.Cleanup(false);
            }
            Say.That("rounds with Cleanup(false)", good);
            good = 0;
            for (var i = 0; i < 20; i++)
            {
                if (Exchange() == "Hello World") good++;
                NetMQConfig.Cleanup(true);
            }
            Say.That("rounds with Cleanup(true)", good);
        }

        private static void BlockedReceiver()
        {
            using var started = new ManualResetEventSlim();
            var receiver = Task.Factory.StartNew(() =>
            {
                var socket = new ResponseSocket("@tcp://127.0.0.1:0");
                started.Set();
                var thrown = Say.Thrown(() => socket.ReceiveFrameString());
                var again = Say.Thrown(() => socket.TryReceiveFrameString(out _));
                var option = Say.Thrown(() => _ = socket.Options.Linger);
                Abandon(socket);
                return $"{thrown?.GetType().Name}: {thrown?.Message} {(thrown as NetMQException)?.ErrorCode}, "
                    + $"then {again?.GetType().Name}, {option?.GetType().Name}";
            }, TaskCreationOptions.LongRunning);
            started.Wait(Say.Timeout);
            Thread.Sleep(50);
            NetMQConfig.Cleanup(false);
            Say.That("a blocked receiver", receiver.Wait(Say.Timeout) ? receiver.Result : "still waits");
            Say.That("afresh", Exchange());
        }

        /// <summary>
        /// Disposes a socket whose context Cleanup(false) took away, which NetMQ may or may not accept.
        /// </summary>
        private static void Abandon(NetMQSocket socket) => Say.Thrown(socket.Dispose);

        private static void Blocking()
        {
            var socket = new RequestSocket();
            var cleanup = Task.Factory.StartNew(() => NetMQConfig.Cleanup(), TaskCreationOptions.LongRunning);
            Say.That("Cleanup waits for an open socket", !cleanup.Wait(Say.Moment));
            Say.ThrowsText("a new socket meanwhile", () => new ResponseSocket().Dispose());
            Say.ThrowsText("another kind", () => new XPublisherSocket().Dispose());
            Say.Throws("the open one, used", () => socket.TrySendFrame("x"));
            socket.Dispose();
            Say.That("until it is disposed", cleanup.Wait(Say.Timeout));
            Say.That("afresh", Exchange());
        }

        private static void NotBlocking()
        {
            var old = new DealerSocket();
            old.BindRandomPort("tcp://127.0.0.1");
            var clock = Stopwatch.StartNew();
            NetMQConfig.Cleanup(false);
            Say.That("Cleanup(false) does not wait", clock.Elapsed < TimeSpan.FromSeconds(5));
            Say.That("a new socket works", Exchange());
            Say.ThrowsText("the old one, used", () => old.TryReceiveFrameString(out _));
            Abandon(old);
            Say.That("the old one is disposed", old.IsDisposed);
            NetMQConfig.Cleanup();
        }

        private static void Unsent()
        {
            using (var push = new PushSocket())
            {
                push.Options.Linger = TimeSpan.FromSeconds(60);
                push.Connect(Say.FreeAddress());
                push.SendFrame("for nobody");
            }
            var clock = Stopwatch.StartNew();
            NetMQConfig.Cleanup(false);
            Say.That("Cleanup(false) does not wait for what is unsent", clock.Elapsed < TimeSpan.FromSeconds(10));
            using (var push = new PushSocket(Say.FreeAddress().Insert(0, ">")))
            {
                push.SendFrame("for nobody");
            }
            clock.Restart();
            NetMQConfig.Cleanup();
            Say.That("nor does Cleanup with linger 0", clock.Elapsed < TimeSpan.FromSeconds(10));
        }

        private static void Pollers()
        {
            for (var i = 0; i < 3; i++)
            {
                using (var pull = new PullSocket("@inproc://work"))
                using (var push = new PushSocket(">inproc://work"))
                using (var queue = new NetMQQueue<string>())
                using (var poller = new NetMQPoller { pull, queue })
                {
                    var got = "";
                    pull.ReceiveReady += (_, e) => queue.Enqueue(e.Socket.ReceiveFrameString());
                    queue.ReceiveReady += (_, e) => got = e.Queue.Dequeue();
                    poller.RunAsync();
                    push.SendFrame($"round {i}");
                    Say.That("poller", Say.Soon(() => got == $"round {i}"));
                }
                NetMQConfig.Cleanup();
            }
        }

        private static void ManySockets()
        {
            var sockets = new NetMQSocket[200];
            for (var i = 0; i < sockets.Length; i++) sockets[i] = new DealerSocket();
            foreach (var socket in sockets) socket.Dispose();
            NetMQConfig.Cleanup();
            NetMQConfig.MaxSockets = 10;
            for (var i = 0; i < 10; i++) sockets[i] = new DealerSocket();
            Say.That("too many", (Say.Thrown(() => new DealerSocket().Dispose()) as NetMQException)?.ErrorCode);
            for (var i = 0; i < 10; i++) sockets[i].Dispose();
            NetMQConfig.MaxSockets = 1024;
            NetMQConfig.Cleanup();
            Say.That("in the end", Exchange());
            NetMQConfig.Cleanup();
        }
    }
}
