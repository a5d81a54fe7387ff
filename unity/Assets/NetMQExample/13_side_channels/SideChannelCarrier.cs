// Lesson 13, the carrier: exchanges with a server, at any time, over a DEALER socket.
//
// An exchange is one frame, and either side sends one whenever it has something to say. An empty one says "I am here",
// and is answered: so it is known whether the server is there.
// The Python side is carrier.py; its server.py shows its use.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample.MLAgents.SideChannels
{
    /// <summary>Make it, use it and dispose it on one thread, but not on Unity's main thread, because receiving
    /// waits.</summary>
    public sealed class SideChannelCarrier : IDisposable
    {
        // After so long a silence an empty exchange says "I am here".
        private static readonly TimeSpan Silence = TimeSpan.FromSeconds(1);

        // For the first try to connect: the second, of twice as long, is over before five seconds are.
        private static readonly TimeSpan Try = TimeSpan.FromSeconds(1.5);

        // A part of an exchange, in bytes: it ends with the message that makes it so large. So much is handed out at
        // once, in Unity in one frame.
        private const int PartBytes = 65536;

        private readonly Queue<byte[]> unsent = new Queue<byte[]>(), unread = new Queue<byte[]>();
        private readonly Stopwatch looked = Stopwatch.StartNew(), said = new Stopwatch();
        private readonly NetMQConnection connection;
        private readonly string endpoint;
        private readonly TimeSpan timeout;
        private readonly Action<string> report;
        private bool answered, away;
        private int tries;
        private TimeSpan silent;
        private List<byte[]> frames;

        /// <summary>Connects, which succeeds even while no server is there.</summary>
        /// <param name="endpoint">The server, such as <c>tcp://127.0.0.1:5563</c>.</param>
        /// <param name="timeout">How long it may be silent; 5 s when left out.</param>
        /// <param name="report">Gets a line when it is silent for longer, and then the carrier goes on trying. Without
        /// it that ends with TimeoutException.</param>
        /// <exception cref="ArgumentException">One of them cannot work; the message names cause and cure.</exception>
        public SideChannelCarrier(string endpoint, TimeSpan? timeout = null, Action<string> report = null)
        {
            this.endpoint = endpoint;
            this.timeout = Require.Seconds("timeout", timeout ?? TimeSpan.FromSeconds(5));
            this.report = report;
            connection = new NetMQConnection(endpoint, () => new DealerSocket(), SideChannel.LargestExchangeBytes);
        }

        /// <summary>Whether an exchange waits for a server that is away. Pack none then: their channels keep the
        /// messages, and of too many drop the oldest.</summary>
        public bool Full => unsent.Count > 0;

        /// <summary>Sends the channels' messages, if there are any, and waits for exchanges, until the first has come:
        /// a large one comes in parts, of which the next calls give the others.</summary>
        /// <returns>Nothing, if none came.</returns>
        /// <exception cref="TimeoutException">The server was silent for too long.</exception>
        public List<byte[]> Exchange(byte[] data, TimeSpan wait, CancellationToken stop = default)
        {
            if (data.Length > 0) unsent.Enqueue(data);
            if (!said.IsRunning || said.Elapsed >= (answered ? Silence : NetMQConnection.Longer(Try, tries)))
                SayHello();
            // Before its first answer a socket may be replaced, and what was sent on it is lost.
            while (answered && unsent.Count > 0 && connection.Socket.TrySendFrame(TimeSpan.Zero, unsent.Peek()))
            {
                connection.Show(true, new[] { unsent.Peek() });
                unsent.Dequeue();
            }
            var received = Receive(wait, stop);
            // A longer gap is no silence of the server's: this program slept, perhaps with the server.
            silent += looked.Elapsed < wait + Silence ? looked.Elapsed : wait + Silence;
            looked.Restart();
            if (received.Count > 0)
            {
                silent = TimeSpan.Zero;
                answered = true;
                away = false;
            }
            else if (silent > timeout && !away)
            {
                var why = FormattableString.Invariant(
                    $"no word from {endpoint} within {timeout.TotalSeconds} s; ")
                    + connection.Cure("is the server running?");
                if (report == null) throw new TimeoutException(why);
                away = true;
                report($"{why} It is tried again and again");
            }
            return received;
        }

        public override string ToString() => $"SideChannelCarrier {endpoint}";
        public void Dispose() => connection.Dispose();

        private void SayHello()
        {
            // A connection that was refused may never be tried again. So each try has a new socket.
            if (said.IsRunning && !answered)
            {
                tries++;
                connection.Close();
            }
            // A server that is there has answered the hello before.
            if (answered && silent >= 2 * Silence) connection.Follow();
            connection.Socket.TrySendFrameEmpty(TimeSpan.Zero);
            said.Restart();
        }

        private List<byte[]> Receive(TimeSpan wait, CancellationToken stop)
        {
            var received = new List<byte[]>();
            var size = 0;
            foreach (var slice in NetMQConnection.Slices(unread.Count > 0 ? TimeSpan.Zero : wait, stop))
            {
                for (var next = slice; size < PartBytes && received.Count < 100; next = TimeSpan.Zero)
                {
                    if (unread.Count == 0 && connection.Socket.TryReceiveMultipartBytes(next, ref frames))
                        Split(frames);
                    if (unread.Count == 0) break;
                    received.Add(unread.Dequeue());
                    size += received[received.Count - 1].Length;
                }
                if (received.Count > 0) break;
            }
            return received;
        }

        // Several smaller exchanges in place of a large one, which would take its time.
        private void Split(List<byte[]> exchange)
        {
            // Several frames are none.
            if (exchange.Count != 1) return;
            connection.Show(false, exchange);
            var data = exchange[0];
            var begin = 0;
            var end = 0;
            while (data.Length - end >= 20)
            {
                var length = BitConverter.ToInt32(data, end + 16);
                if (length < 0 || length > data.Length - end - 20) break;
                end += 20 + length;
                if (end - begin < PartBytes) continue;
                unread.Enqueue(data.AsSpan(begin, end - begin).ToArray());
                begin = end;
            }
            if (begin < data.Length || data.Length == 0) unread.Enqueue(data.AsSpan(begin).ToArray());
        }
    }
}
