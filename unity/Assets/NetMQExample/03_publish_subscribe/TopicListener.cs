// Lesson 03, the smallest subscriber: every message that begins with a prefix, as text.
//
// Take home: this file and NetMQLifetime.cs of lesson 01, if no message needs to be missed with notice; else see
// PoseSubscriber.cs. What was sent before the publisher knew of this listener is lost, and nobody says so.
// Bytes: UTF-8 text, one frame, as python/03_publish_subscribe/server.py sends it.
// Trouble: a topic is a prefix. `news` brings newsflash/ as well; the delimiter at its end, `news/`, cures that.
using System;
using System.Text;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample
{
    /// <summary>Listens over a SUB socket. Make it, use it and dispose it on one thread.</summary>
    public sealed class TopicListener : IDisposable
    {
        private readonly NetMQLifetime lifetime = new NetMQLifetime();
        private readonly SubscriberSocket stream = new SubscriberSocket();
        private readonly string endpoint;

        /// <summary>Subscribes and connects, which succeeds even while no publisher is there.</summary>
        /// <param name="endpoint">The publisher, such as <c>tcp://127.0.0.1:5553</c>.</param>
        /// <param name="prefix">How the messages begin; empty for all of them.</param>
        /// <exception cref="ArgumentException">The endpoint cannot work; the message names cause and cure.</exception>
        public TopicListener(string endpoint, string prefix)
        {
            this.endpoint = endpoint;
            try
            {
                // Without the encoding, NetMQ makes a question mark of every letter that is not ASCII.
                stream.Subscribe(prefix, Encoding.UTF8);
                NetMQLifetime.Connect(stream, endpoint);
            }
            catch
            {
                Dispose();
                throw;
            }
        }

        /// <summary>Waits for the next message, and so not for Unity's main thread.</summary>
        /// <param name="patience">How long to wait; zero takes only what is there.</param>
        /// <exception cref="TimeoutException">None came.</exception>
        public string Receive(TimeSpan patience)
        {
            if (!stream.TryReceiveFrameString(patience, out var text, out var more))
                throw new TimeoutException(FormattableString.Invariant(
                    $"nothing from {endpoint} within {patience.TotalSeconds} s; is the server running?"));
            // Several frames are one message: its rest must not be taken for the next one.
            while (more) stream.SkipFrame(out more);
            return text;
        }

        /// <summary>Closes the socket, then leaves NetMQ.</summary>
        public void Dispose()
        {
            stream.Dispose();
            lifetime.Dispose();
        }
    }
}
