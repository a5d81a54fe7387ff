// The kit's own clients as contenders, each with its lesson's server, and NetMQ without any of them.
using System;
using System.Linq;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;
using static NetMQExample.Lab.Contender;

namespace NetMQExample.Lab
{
    internal static class Kit
    {
        // Where curve_server.py makes them; the lab's programs run in the kit's folder.
        public const string Keys = ".build/lab_keys";

        // Lesson 01.
        public static Contender Hello(string endpoint, string text)
        {
            var requester = new HelloRequester(endpoint);
            return new Contender(requester, () => Check(requester.Request(text, Limit) == "World"));
        }

        // Lesson 02, with a server that keeps no journal.
        public static Contender Pirate(string endpoint, string text)
        {
            var requester = new LazyPirateRequester(endpoint);
            return new Contender(requester, () => Check(requester.Request(text) == "World"));
        }

        // Lesson 04. In place of Unity's frames it polls whenever nothing else wants the processor.
        public static Contender Background(string endpoint, string text)
        {
            var client = new BackgroundClient(endpoint);
            string reply = null;
            // Made once: at the call they would be new objects for each request.
            Action<string> onReply = given => reply = given;
            Action<string> onError = why => throw new InvalidOperationException(why);
            return new Contender(client, () =>
            {
                reply = null;
                Check(client.Request(text, onReply, onError));
                for (client.Poll(); reply == null; client.Poll()) Thread.Yield();
                Check(reply == "World");
            });
        }

        // Asks without waiting whether the reply is there, again and again, as a well-known example does.
        public static Contender BusyWait(string endpoint, string text)
        {
            var socket = new RequestSocket();
            socket.Connect(endpoint);
            return new Contender(socket, () =>
            {
                socket.SendFrame(text);
                string reply;
                while (!socket.TryReceiveFrameString(out reply)) { }
                Check(reply == "World");
            });
        }

        // Lesson 05 with new arrays for each message, or with lesson 08's buffers that are used again.
        public static Contender Messages(string endpoint, byte[] payload, bool pooled)
        {
            var requester = pooled ? new PooledRequester(endpoint) : new MessageRequester(endpoint);
            var request = new Message("echo", 1);
            request.Arrays.Add(new MessageArray("uint8", payload, payload.Length));
            return new Contender(requester, () =>
            {
                // The pool is for all sockets of the process.
                if (pooled) PooledBuffers.Use();
                else BufferPool.SetGCBufferPool();
                Check(requester.Request(request, Limit).Arrays[0].Data.Length == payload.Length);
            });
        }

        // Lesson 08: a picture of 240 rows, and an action back.
        public static Contender Steer(string endpoint, int size)
        {
            var driver = new DriverClient(endpoint, Limit, 1, why => throw new TimeoutException(why));
            var pictures = new CameraPictures("center", size / 720, 240, 3);
            return new Contender(driver, () => Check(driver.Ask(pictures.ToMessage()) != null));
        }

        // Lesson 06 with a number of requests in flight.
        public static Contender Many(string endpoint, int size, int window)
        {
            var requester = new ManyRequester(endpoint, window, Limit);
            var text = "echo ".PadRight(size, 'x');
            var batch = 20 * window + 100;
            return new Contender(requester, () => Check(requester.RequestMany(Enumerable.Repeat(text, batch))
                .All(answer => answer.Reply.Length == text.Length - 5)), batch);
        }

        // NetMQ and nothing else: one frame each way over a DEALER, with lesson 08's pool. ZeroMQ's own limit.
        public static Contender Bare(string endpoint, byte[] payload, int answer, ClientKeys keys = null)
        {
            var socket = new DealerSocket();
            if (answer < payload.Length) payload[0] = Short;
            socket.Options.Linger = TimeSpan.Zero;
            keys?.Apply(socket);
            socket.Connect(endpoint);
            var incoming = new Msg();
            incoming.InitEmpty();
            return new Contender(socket, () =>
            {
                PooledBuffers.Use();
                var msg = new Msg();
                // Lent: the answer proves that NetMQ is done with it.
                msg.InitGC(payload, payload.Length);
                if (!socket.TrySend(ref msg, Limit, false)) throw new TimeoutException("the server takes no more");
                msg.Close();
                if (!socket.TryReceive(ref incoming, Limit)) throw new TimeoutException("no reply");
                Check(incoming.Size == answer);
            });
        }
    }
}
