// The kit's own clients as contenders, each with its lesson's server, and NetMQ without any of them.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample.Lab
{
    /// <summary>Lesson 01. Its server takes blanks after Hello, and answers World.</summary>
    internal sealed class Hello : Contender
    {
        private readonly HelloRequester requester;
        private readonly string text;

        public Hello(string endpoint, int size) : base(size)
        {
            requester = new HelloRequester(endpoint);
            text = "Hello".PadRight(size);
        }

        public override void Send() => requester.Send(text, Timeout);

        public override void Receive() => Check(requester.Receive(Timeout) == "World");

        public override void Dispose() => requester.Dispose();
    }

    /// <summary>Lesson 02, with a server that keeps no journal.</summary>
    internal sealed class Pirate : Contender
    {
        private readonly LazyPirateRequester requester;
        private readonly string text;
        private string reply;

        public Pirate(string endpoint, int size) : base(size)
        {
            requester = new LazyPirateRequester(endpoint);
            text = "Hello".PadRight(size);
        }

        public override void Send() => reply = requester.Request(text);

        // It was there before Send returned.
        public override void Receive() => Check(reply == "World");

        public override void Dispose() => requester.Dispose();
    }

    /// <summary>Lesson 04. In place of Unity's frames it polls whenever nothing else wants the processor.</summary>
    internal sealed class Background : Contender
    {
        private readonly BackgroundClient client;
        private readonly string text;
        private readonly Action<string> onReply, onError;
        private string reply;

        public Background(string endpoint, int size) : base(size)
        {
            client = new BackgroundClient(endpoint);
            text = "Hello".PadRight(size);
            onReply = given => reply = given;
            onError = why => throw new InvalidOperationException(why);
        }

        public override void Send()
        {
            reply = null;
            Check(client.Request(text, onReply, onError));
        }

        public override void Receive()
        {
            for (client.Poll(); reply == null; client.Poll()) Thread.Yield();
            Check(reply == "World");
        }

        public override void Dispose() => client.Dispose();
    }

    /// <summary>Asks without waiting whether the reply is there, again and again, as a well-known example
    /// does.</summary>
    internal sealed class BusyWait : Contender
    {
        private readonly RequestSocket socket = new RequestSocket();
        private readonly string text;

        public BusyWait(string endpoint, int size) : base(size)
        {
            text = "Hello".PadRight(size);
            socket.Connect(endpoint);
        }

        public override void Send() => socket.SendFrame(text);

        public override void Receive()
        {
            string reply;
            while (!socket.TryReceiveFrameString(out reply)) { }
            Check(reply == "World");
        }

        public override void Dispose() => socket.Dispose();
    }

    /// <summary>Lesson 05 with new arrays for each message, or with lesson 08's buffers that are used again.</summary>
    internal sealed class Messages : Contender
    {
        private readonly MessageRequester requester;
        private readonly Message request = new Message("echo", 1);
        private readonly bool pooled;
        private Message reply;

        public Messages(string endpoint, int size, bool pooled) : base(size)
        {
            this.pooled = pooled;
            request.Arrays.Add(new MessageArray("uint8", Payload, size));
            requester = pooled ? new PooledRequester(endpoint) : new MessageRequester(endpoint);
        }

        public override void Send()
        {
            // The pool is for all sockets of the process.
            if (pooled) PooledBuffers.Use();
            else BufferPool.SetGCBufferPool();
            reply = requester.Request(request, Timeout);
        }

        public override void Receive() => Check(reply.Arrays[0].Data.Length == Payload.Length);

        public override void Dispose() => requester.Dispose();
    }

    /// <summary>Lesson 08: a picture of 240 rows, and an action back.</summary>
    internal sealed class Steer : Contender
    {
        private readonly DriverClient driver;
        private readonly CameraPictures pictures;

        public Steer(string endpoint, int size) : base(size)
        {
            driver = new DriverClient(endpoint, Timeout, 1, why => throw new TimeoutException(why));
            pictures = new CameraPictures("center", size / 720, 240, 3);
        }

        public override void Send() => Check(driver.Ask(pictures.ToMessage()) != null);

        // It was there before Send returned.
        public override void Receive() { }

        public override void Dispose() => driver.Dispose();
    }

    /// <summary>Lesson 06 with a number of requests in flight.</summary>
    internal sealed class Many : Contender
    {
        private readonly ManyRequester requester;
        private readonly string text;
        private readonly int batch;

        public Many(string endpoint, int size, int window) : base(size)
        {
            requester = new ManyRequester(endpoint, window, Timeout);
            text = "echo ".PadRight(size, 'x');
            batch = 20 * window + 100;
        }

        public override int Echo(List<double> waits)
        {
            Check(requester.RequestMany(Enumerable.Repeat(text, batch))
                .All(answer => answer.Reply.Length == text.Length - 5));
            return batch;
        }

        public override void Send() => throw new NotSupportedException();

        public override void Receive() => throw new NotSupportedException();

        public override void Dispose() => requester.Dispose();
    }

    /// <summary>NetMQ and nothing else: one frame each way over a DEALER, with lesson 08's pool. ZeroMQ's own
    /// limit.</summary>
    internal sealed class Bare : Contender
    {
        private readonly DealerSocket socket = new DealerSocket();
        private readonly int answer;
        private Msg incoming = new Msg();

        public Bare(string endpoint, int size, int answer, ClientKeys keys = null) : base(size)
        {
            this.answer = answer;
            if (answer < size) Payload[0] = Short;
            incoming.InitEmpty();
            socket.Options.Linger = TimeSpan.Zero;
            keys?.Apply(socket);
            socket.Connect(endpoint);
        }

        public override void Send()
        {
            PooledBuffers.Use();
            var msg = new Msg();
            // Lent: the answer proves that NetMQ is done with it.
            msg.InitGC(Payload, Payload.Length);
            if (!socket.TrySend(ref msg, Timeout, false)) throw new TimeoutException("the server takes no more");
            msg.Close();
        }

        public override void Receive()
        {
            if (!socket.TryReceive(ref incoming, Timeout)) throw new TimeoutException("no reply");
            Check(incoming.Size == answer);
        }

        public override void Dispose() => socket.Dispose();
    }
}
