// Every contender of the lab can send its payload, and wait until the server's answer is there.
//
// A server of the lab answers with the same bytes, or, if the first byte is 3, with the first 200, which is about what
// an action of lesson 08 takes.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Globalization;

namespace NetMQExample.Lab
{
    internal abstract class Contender : IDisposable
    {
        public const byte Answer = 1, Short = 3;

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
            // many@64 has 64 in flight, bare@200 expects 200 bytes.
            var parts = name.Split('@');
            var number = parts.Length > 1 ? int.Parse(parts[1], CultureInfo.InvariantCulture) : 0;
            switch (parts[0])
            {
                case "tcp": return new Tcp(endpoint, size);
                case "json": return new JsonLines(endpoint, size);
                case "http": return new Http(endpoint, size);
                case "websocket": return new WebSockets(endpoint, size);
                case "hello": return new Hello(endpoint, size);
                case "pirate": return new Pirate(endpoint, size);
                case "background": return new Background(endpoint, size);
                case "busy": return new BusyWait(endpoint, size);
                case "naive": return new Messages(endpoint, size, false);
                case "pooled": return new Messages(endpoint, size, true);
                case "many": return new Many(endpoint, size, number);
                case "bare": return new Bare(endpoint, size, number > 0 ? number : size);
                case "curve": return new Bare(endpoint, size, size, new ClientKeys(Keys));
                case "steer": return new Steer(endpoint, size);
                default: throw new ArgumentException($"no contender {name}");
            }
        }

        protected static void Check(bool same)
        {
            if (!same) throw new InvalidOperationException("the answer is not the one that was expected");
        }
    }
}
