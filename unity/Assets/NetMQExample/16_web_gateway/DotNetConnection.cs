// The WebSocket of .NET: no package and no DLL. It waits on the thread pool.
using System;
using System.Collections.Concurrent;
using System.IO;
using System.Net.WebSockets;
using System.Text;
using System.Threading;
using System.Threading.Tasks;

namespace NetMQExample
{
    /// <summary>A connection outside of a browser.</summary>
    public sealed class DotNetConnection : IWebConnection
    {
        // The gateway answers what it is asked: who sends more than this at once is no gateway.
        private const int MostMessages = 64, MaxBytes = 4 * 1024 * 1024;
        // Says to all at once that an assembly reload has begun.
        private static readonly CancellationTokenSource Reload = new CancellationTokenSource();
        // The tasks that run on the thread pool, or wait for their turn there.
        private static int running;
        private readonly ConcurrentQueue<string> received = new ConcurrentQueue<string>();
        private readonly CancellationTokenSource stop = new CancellationTokenSource();
        private readonly ClientWebSocket socket = new ClientWebSocket();
        private volatile string closed;
        private volatile bool open;
        private Task sending = Task.CompletedTask;

        static DotNetConnection()
        {
            // Only Mono unloads a domain. In CoreCLR, to which Unity moves, the event never comes, and what listens to
            // it is never unloaded.
            if (Environment.Version.Major < 5) AppDomain.CurrentDomain.DomainUnload += Unload;
        }

        // A task that begins in the midst of an assembly reload starts threads that nobody ends, and Mono can crash of
        // that. All were told to leave, and most often none is left.
        private static void Unload(object domain, EventArgs nothing)
        {
            Reload.Cancel();
            for (var rest = 5000; rest > 0 && Volatile.Read(ref running) > 0; rest--) Thread.Sleep(1);
        }

        /// <summary>Begins to connect.</summary>
        /// <param name="address">A <c>ws://</c> or <c>wss://</c> address.</param>
        public DotNetConnection(string address)
        {
            WebText.Given("address", address);
            _ = OnPool(() => Run(address));
        }

        public bool IsOpen => open && closed == null;
        public string Closed => closed;

        public void Send(string text)
        {
            var before = sending;
            // One after the other: it refuses to send two messages at the same time.
            sending = OnPool(async () =>
            {
                await before.ConfigureAwait(false);
                var bytes = new ArraySegment<byte>(Encoding.UTF8.GetBytes(text));
                var kind = WebSocketMessageType.Text;
                try { await socket.SendAsync(bytes, kind, true, stop.Token).ConfigureAwait(false); }
                catch (Exception e) { closed ??= e.Message; }
            });
        }

        public bool TryReceive(out string text) => received.TryDequeue(out text);

        /// <summary>Leaves at once, and drops messages that are under way.</summary>
        public void Dispose() => stop.Cancel();

        // On Unity's own thread everything after an await would wait for the next frame.
        private static async Task OnPool(Func<Task> work)
        {
            Interlocked.Increment(ref running);
            try { await Task.Run(work).ConfigureAwait(false); }
            finally { Interlocked.Decrement(ref running); }
        }

        private async Task Run(string address)
        {
            try
            {
                // The way to this machine needs no proxy, whatever the system has set.
                socket.Options.Proxy = null;
                // On Mono a connection that is given up before it has come about stays open until garbage is collected:
                // it may come about first. A reload of scripts does not wait: their AppDomain takes it along.
                using var timeout = CancellationTokenSource.CreateLinkedTokenSource(Reload.Token);
                using var stopped = stop.Token.Register(() => timeout.CancelAfter(10000));
                await socket.ConnectAsync(new Uri(address), timeout.Token).ConfigureAwait(false);
                open = true;
                while (await Receive().ConfigureAwait(false) is string text) received.Enqueue(text);
                closed ??= socket.CloseStatusDescription ?? "the other side has left";
            }
            // The caller reads any error here.
            catch (Exception e) { closed ??= e.Message; }
            // Not from another thread: a WebSocket that is disposed while it connects leaves its connection open.
            finally { socket.Dispose(); }
        }

        private async Task<string> Receive()
        {
            using var message = new MemoryStream();
            var part = new ArraySegment<byte>(new byte[4096]);
            for (var ended = false; !ended;)
            {
                var result = await socket.ReceiveAsync(part, stop.Token).ConfigureAwait(false);
                if (result.MessageType == WebSocketMessageType.Close) return null;
                message.Write(part.Array, 0, result.Count);
                ended = result.EndOfMessage;
                if (message.Length > MaxBytes || received.Count > MostMessages)
                    throw new InvalidDataException("more came than a gateway sends");
            }
            return Encoding.UTF8.GetString(message.GetBuffer(), 0, (int)message.Length);
        }
    }
}
