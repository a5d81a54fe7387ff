// What every contender of the lab can do: send its payload, and wait until the server's answer is there.
//
// The first byte of a payload tells the server of the lab what to do: 1 answers with the same bytes, 0 does nothing, and
// 2 sends to as many clients as bytes 1 to 4 say, once they are there, as many of the same messages as bytes 5 to 8 say,
// and 3 answers with the first 200 bytes, which is about what an action of lesson 08 takes.
// The servers of the lessons know nothing of this, and always answer.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Globalization;

namespace NetMQExample.Lab
{
    internal abstract class Contender : IDisposable
    {
        public const byte NoAnswer = 0, Answer = 1, Publish = 2, Short = 3;

        // Where curve_server.py makes them; the lab's programs run in the kit's folder.
        private const string Keys = ".build/lab_keys";

        protected static readonly TimeSpan Timeout = TimeSpan.FromSeconds(20);

        protected Contender(int size)
        {
            Payload = new byte[size];
            Payload[0] = Answer;
        }

        public byte[] Payload { get; }

        public abstract void Send();

        public abstract void Receive();

        public abstract void Dispose();

        /// <summary>One round trip, or of those with many in flight a thousand.</summary>
        /// <returns>How many messages were answered.</returns>
        public virtual int Echo(List<double> waits)
        {
            var start = Stopwatch.GetTimestamp();
            Send();
            Receive();
            waits.Add((Stopwatch.GetTimestamp() - start) * 1e6 / Stopwatch.Frequency);
            return 1;
        }

        public static Contender Make(string name, string endpoint, int size)
        {
            // many@64 has 64 in flight, hello@200 looks for its reply for 200 us before it sleeps, subscriber@10 is one of ten,
            // gateway@1 speaks Socket.IO.
            var parts = name.Split('@');
            var number = parts.Length > 1 ? int.Parse(parts[1], CultureInfo.InvariantCulture) : 0;
            // Where the server has two, the second is that of its publisher.
            var endpoints = endpoint.Split(',');
            endpoint = endpoints[0];
            switch (parts[0])
            {
                case "tcp": return new Tcp(endpoint, size);
                case "json": return new JsonLines(endpoint, size);
                case "http": return new Http(endpoint, size);
                case "websocket": return new WebSockets(endpoint, size);
                case "gateway": return new Gateway(endpoint, size, number > 0);
                case "hello": return number > 0 ? new Spinning(endpoint, size, number) : (Contender)new Hello(endpoint, size);
                case "busy": return new BusyWait(endpoint, size);
                case "naive": return new Messages(endpoint, size, false);
                case "pooled": return new Messages(endpoint, size, true);
                case "many": return new Many(endpoint, size, number);
                case "bare": return new Bare(endpoint, size, number > 0 ? number : size);
                case "curve": return new Bare(endpoint, size, size, new ClientKeys(Keys));
                case "steer": return new Steer(endpoint, size);
                case "subscriber": return new Subscriber(endpoint, endpoints[1], size, number);
                default: throw new ArgumentException($"no contender {name}");
            }
        }

        protected static void Check(bool same)
        {
            if (!same) throw new InvalidOperationException("the answer is not the one that was expected");
        }
    }
}
