// Every contender of the lab sends its payload, and waits until the server's answer is there.
//
// A server of the lab answers with the same bytes, or, if the first byte is 3, with the first 200, which is about what
// an action of lesson 08 takes.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Globalization;

namespace NetMQExample.Lab
{
    internal sealed class Contender : IDisposable
    {
        public const byte Answer = 1, Short = 3;
        public static readonly TimeSpan Limit = TimeSpan.FromSeconds(20);
        private readonly IDisposable client;
        private readonly Action exchange;
        private readonly int messages;

        /// <summary>A client, one round trip of it, and how many messages are answered in that.</summary>
        public Contender(IDisposable client, Action exchange, int messages = 1) =>
            (this.client, this.exchange, this.messages) = (client, exchange, messages);

        public static Contender Make(string name, string endpoint, int size)
        {
            // many@64 has 64 in flight, bare@200 expects 200 bytes.
            var parts = name.Split('@');
            var number = parts.Length > 1 ? int.Parse(parts[1], CultureInfo.InvariantCulture) : 0;
            var payload = new byte[size];
            payload[0] = Answer;
            // The servers of lessons 01 to 04 take blanks after Hello, and answer World.
            var text = "Hello".PadRight(size);
            return parts[0] switch
            {
                "tcp" => Plain.Tcp(endpoint, payload),
                "json" => Plain.JsonLines(endpoint, payload),
                "http" => Plain.Http(endpoint, payload),
                "websocket" => Plain.WebSocket(endpoint, payload),
                "hello" => Kit.Hello(endpoint, text),
                "pirate" => Kit.Pirate(endpoint, text),
                "background" => Kit.Background(endpoint, text),
                "busy" => Kit.BusyWait(endpoint, text),
                "naive" => Kit.Messages(endpoint, payload, false),
                "pooled" => Kit.Messages(endpoint, payload, true),
                "many" => Kit.Many(endpoint, size, number),
                "bare" => Kit.Bare(endpoint, payload, number > 0 ? number : size),
                "curve" => Kit.Bare(endpoint, payload, size, new ClientKeys(Kit.Keys)),
                "steer" => Kit.Steer(endpoint, size),
                _ => throw new ArgumentException($"no contender {name}"),
            };
        }

        public static void Check(bool same)
        {
            if (!same) throw new InvalidOperationException("the answer is not the one that was expected");
        }

        /// <summary>One round trip, whose time is added, unless it has many in flight.</summary>
        /// <returns>How many messages were answered.</returns>
        public int Echo(List<double> waits)
        {
            var start = Stopwatch.GetTimestamp();
            exchange();
            if (messages == 1) waits.Add((Stopwatch.GetTimestamp() - start) * 1e6 / Stopwatch.Frequency);
            return messages;
        }

        public void Dispose() => client.Dispose();
    }
}
