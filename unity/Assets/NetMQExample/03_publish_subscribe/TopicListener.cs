// Lesson 03, publish-subscribe: listen to every message that begins with a topic, or only to the newest.
//
// The Python side is python/03_publish_subscribe/server.py.
// Bytes: UTF-8 text, which begins with its topic. Of a message of several frames the text is that of all, with a blank
// between them; ReceiveFrames hands them over apart, as bytes.
// Messages from before the publisher knew of this listener are lost, and so are those that find the queues full.
// Nothing reports that. Trouble: a topic is a prefix. `news` also gets newsflash/; the delimiter, `news/`, cures that.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Text;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample
{
    /// <summary>Listens over a SUB socket. Make it, use it and dispose it on one thread.</summary>
    public sealed class TopicListener : IDisposable
    {
        private static readonly TimeSpan Silence = TimeSpan.FromSeconds(2);
        private readonly Stopwatch silent = Stopwatch.StartNew();
        private readonly NetMQConnection connection;
        private readonly string endpoint, topic;
        private bool heard;

        /// <summary>Subscribes and connects, which succeeds even while no publisher is there.</summary>
        /// <param name="endpoint">The publisher, such as <c>tcp://127.0.0.1:5553</c>.</param>
        /// <param name="topic">How the messages begin; empty, as when left out, for all of them.</param>
        /// <param name="hwm">The high watermark: how many messages may wait here; 0 for any number.</param>
        /// <exception cref="ArgumentException">One of them cannot work; the message names cause and cure.</exception>
        public TopicListener(string endpoint, string topic = "", int hwm = 1000)
        {
            Require.Count("hwm", hwm, least: 0);
            this.endpoint = endpoint;
            this.topic = topic ?? throw new ArgumentException("topic must be a text; an empty one takes all messages");
            connection = new NetMQConnection(endpoint, () =>
            {
                // A laptop that sleeps tells nobody: a silent publisher is asked every second, and one that does not
                // answer in 2.5 more gets a new connection.
                var socket = new SubscriberSocket
                {
                    Options = { ReceiveHighWatermark = hwm, HeartbeatInterval = TimeSpan.FromSeconds(1),
                        HeartbeatTimeout = TimeSpan.FromSeconds(2.5) },
                };
                // Without the encoding, NetMQ makes a question mark of every letter that is not ASCII.
                socket.Subscribe(topic, Encoding.UTF8);
                return socket;
            });
        }

        /// <summary>Waits for the next message, and so not for Unity's main thread.</summary>
        /// <param name="timeout">How long to wait; zero takes only what is there.</param>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        /// <exception cref="TimeoutException">None came.</exception>
        /// <exception cref="OperationCanceledException"><paramref name="stop"/> was cancelled.</exception>
        public string Receive(TimeSpan timeout, CancellationToken stop = default) =>
            Text(ReceiveFrames(timeout, stop));

        /// <summary>Waits for the next message, as <see cref="Receive"/> does.</summary>
        /// <param name="timeout">How long to wait; zero takes only what is there.</param>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        /// <returns>Its frames as they came, such as a topic and a picture.</returns>
        /// <exception cref="TimeoutException">None came.</exception>
        /// <exception cref="OperationCanceledException"><paramref name="stop"/> was cancelled.</exception>
        public List<byte[]> ReceiveFrames(TimeSpan timeout, CancellationToken stop = default)
        {
            var waited = Stopwatch.StartNew();
            var renew = Silence;
            foreach (var slice in NetMQConnection.Slices(timeout, stop))
            {
                if (TryReceive(slice, out var frames))
                {
                    heard = true;
                    return frames;
                }
                if (heard && silent.Elapsed >= Silence && connection.Follow()) silent.Restart();
                if (heard || waited.Elapsed < renew) continue;
                // Where another program had the port before, libzmq connects no more. On a far line it takes its time.
                connection.Close();
                renew *= 3;
            }
            throw new TimeoutException(FormattableString.Invariant(
                $"nothing from {endpoint} within {timeout.TotalSeconds} s; ")
                + connection.Cure($"is the server running, with topic '{topic}', or a message over 64 KB?"));
        }

        /// <summary>Waits for a message, then takes all that wait behind it: only the last one counts. (libzmq can keep
        /// the newest by itself, with CONFLATE; NetMQ has no such option.)</summary>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        /// <exception cref="TimeoutException">None came.</exception>
        /// <exception cref="OperationCanceledException"><paramref name="stop"/> was cancelled.</exception>
        public string Newest(TimeSpan timeout, CancellationToken stop = default)
        {
            var newest = ReceiveFrames(timeout, stop);
            // The limit is for a publisher that sends faster than this loop takes.
            for (var i = 0; i < 10_000 && TryReceive(TimeSpan.Zero, out var later); i++) newest = later;
            return Text(newest);
        }

        public override string ToString() => $"TopicListener {endpoint}";
        public void Dispose() => connection.Dispose();
        private static string Text(List<byte[]> frames) => string.Join(" ", frames.ConvertAll(NetMQConnection.Text));

        private bool TryReceive(TimeSpan wait, out List<byte[]> frames)
        {
            frames = null;
            if (!connection.Socket.TryReceiveMultipartBytes(wait, ref frames)) return false;
            silent.Restart();
            connection.Show(false, frames);
            return true;
        }
    }
}
