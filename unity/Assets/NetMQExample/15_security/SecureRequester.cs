// Lesson 15, the client's side: a requester with keys, that says so when it is refused.
//
//     using var requester = new SecureRequester("tcp://127.0.0.1:5565", new ClientKeys("keys"));
//     requester.Request("Hello");        the reply, or TimeoutException
//
// The Python side is python/15_security/server.py.
// Bytes: UTF-8 text, one frame each way.
// A refused client is told nothing: it is connected, and cut off in the handshake. NetMQ then tries again for ever and
// libzmq never, and neither says why; so each try has a new socket, and the line says what was seen.
using System;
using System.Collections.Generic;
using System.Threading;
using NetMQ;
using NetMQ.Monitoring;
using NetMQ.Sockets;

namespace NetMQExample
{
    /// <summary>Asks a server that knows its clients by their keys. Make it, use it and dispose it on one thread, and
    /// not on Unity's main thread: a request blocks until it is answered or given up.</summary>
    public sealed class SecureRequester : IDisposable
    {
        private const string ThrownOut = "connected and thrown out";
        // Between two tries, where the first was over at once.
        private static readonly TimeSpan Pause = TimeSpan.FromMilliseconds(250);

        private readonly NetMQConnection connection;
        private readonly OneAtATime calls = new OneAtATime(nameof(SecureRequester));
        private readonly string endpoint;
        private readonly ClientKeys keys;
        private readonly TimeSpan timeout;
        private readonly int tries;
        private readonly Action<string> report;
        // It is never run: what the monitor reports is looked at here, between two slices of waiting.
        private NetMQPoller nobody;
        private NetMQMonitor monitor;
        private PairSocket reports;
        private bool cutOff;
        private int number;

        /// <summary>Connects, which succeeds even while no server is there, or one that refuses.</summary>
        /// <param name="endpoint">The server, such as <c>tcp://127.0.0.1:5565</c>.</param>
        /// <param name="keys">This client's keys and the server's; null speaks plain, which the server refuses.</param>
        /// <param name="timeout">How long to wait for the reply to the first try, 1 s when left out. Each one waits
        /// twice as long as the one before, up to 8 times.</param>
        /// <param name="tries">How often to send a request before giving up.</param>
        /// <param name="report">Called, on the thread of the request, with a line to log before each retry, unless it
        /// is null.</param>
        /// <exception cref="ArgumentException">One of them cannot work; the message names cause and cure.</exception>
        public SecureRequester(string endpoint, ClientKeys keys = null, TimeSpan? timeout = null, int tries = 3,
            Action<string> report = null)
        {
            this.endpoint = endpoint;
            this.keys = keys;
            this.timeout = Require.Seconds("timeout", timeout ?? TimeSpan.FromSeconds(1));
            this.tries = Require.Count("tries", tries);
            this.report = report ?? (line => { });
            // Before there is anything to close again.
            NetMQConnection.Check(endpoint);
            connection = new NetMQConnection(endpoint, Make);
        }

        /// <summary>Sends a request until it is answered.</summary>
        /// <param name="text">The request, sent as UTF-8.</param>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        /// <exception cref="TimeoutException">No try was answered; the message says why.</exception>
        /// <exception cref="ArgumentException">The text has more than 65,536 bytes.</exception>
        public string Request(string text, CancellationToken stop = default)
        {
            Require.Text("text", text);
            using var alone = calls.Begin();
            number++;
            for (var attempt = 1; ; attempt++)
            {
                var limit = NetMQConnection.Longer(timeout, attempt - 1);
                if (Try(text, limit, stop, out var reply, out var trouble)) return reply;
                // A REQ socket that waits for a reply refuses to send, and one that was refused is dead.
                Close();
                if (attempt == tries)
                    throw new TimeoutException($"{NetMQConnection.Tries(tries)} to ask {endpoint}, the last: "
                        + $"{trouble}; "
                        + (trouble == ThrownOut
                            ? Advice()
                            : connection.Cure("is the server running, or its reply over 64 KB?")));
                report($"{number}: {trouble}; try {attempt + 1} of {tries}");
            }
        }

        public override string ToString() => $"SecureRequester {endpoint}";

        public void Dispose()
        {
            Close();
            connection.Dispose();
        }

        private bool Try(
            string text, TimeSpan limit, CancellationToken stop, out string reply, out string trouble)
        {
            List<byte[]> frames = null;
            reply = "";
            trouble = ThrownOut;
            var sent = false;
            foreach (var slice in NetMQConnection.Slices(limit, stop))
            {
                // Without waiting: where this was refused already there is no connection to send on.
                sent = sent || connection.TrySend(TimeSpan.Zero, stop, text);
                if (sent && connection.Socket.TryReceiveMultipartBytes(slice, ref frames))
                {
                    connection.Show(false, frames);
                    reply = string.Join(" ", frames.ConvertAll(NetMQConnection.Text));
                    return true;
                }
                reports.Poll(sent ? TimeSpan.Zero : slice);
                if (!cutOff) continue;
                // Most often it is refused again; and if the server was started anew, it is there a moment later.
                stop.WaitHandle.WaitOne(Pause);
                return false;
            }
            trouble = FormattableString.Invariant($"no reply within {limit.TotalSeconds} s");
            return false;
        }

        private string Advice() => keys == null
            ? "a server with keys refuses who has none"
            : "is this client on its list, is server.key its key, and has it keys at all? This client's is "
                + keys.PublicKey;

        private NetMQSocket Make()
        {
            var socket = new RequestSocket();
            keys?.Apply(socket);
            // Before it connects, so that no report is missed.
            var where = $"inproc://{Guid.NewGuid():N}";
            socket.Monitor(where, SocketEvents.Disconnected);
            reports = new PairSocket();
            cutOff = false;
            monitor = new NetMQMonitor(reports, where, true);
            monitor.Disconnected += (sender, e) => cutOff = true;
            nobody = new NetMQPoller();
            monitor.AttachToPoller(nobody);
            return socket;
        }

        private void Close()
        {
            monitor?.Dispose();
            nobody?.Dispose();
            monitor = null;
            nobody = null;
            connection.Close();
        }
    }
}
