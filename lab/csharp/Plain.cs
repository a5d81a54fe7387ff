// Contenders over a plain TCP socket: the limit, and what people write first.
using System;
using System.IO;
using System.Net;
using System.Net.Sockets;
using System.Text;

namespace NetMQExample.Lab
{
    /// <summary>The limit: four bytes of length, then the payload, in buffers that are made once.</summary>
    internal sealed class Tcp : Contender
    {
        private readonly Socket socket;
        private readonly byte[] outgoing, incoming;

        public Tcp(string endpoint, int size) : base(size)
        {
            socket = Connected(endpoint);
            (outgoing, incoming) = (new byte[4 + size], new byte[4 + size]);
            BitConverter.GetBytes(size).CopyTo(outgoing, 0);
        }

        public static Socket Connected(string endpoint)
        {
            var address = new Uri(endpoint);
            var socket = new Socket(AddressFamily.InterNetwork, SocketType.Stream, ProtocolType.Tcp)
            {
                NoDelay = true,
                ReceiveTimeout = (int)Timeout.TotalMilliseconds,
            };
            socket.Connect(IPAddress.Parse(address.Host), address.Port);
            return socket;
        }

        public override void Send()
        {
            // The first nine bytes are all that ever changes.
            Array.Copy(Payload, 0, outgoing, 4, Math.Min(9, Payload.Length));
            for (var sent = 0; sent < outgoing.Length;)
                sent += socket.Send(outgoing, sent, outgoing.Length - sent, SocketFlags.None);
        }

        public override void Receive()
        {
            for (var received = 0; received < incoming.Length;)
            {
                var some = socket.Receive(incoming, received, incoming.Length - received, SocketFlags.None);
                if (some == 0) throw new IOException("the server hung up");
                received += some;
            }
            Check(incoming[0] == (byte)Payload.Length && incoming[^1] == outgoing[^1]);
        }

        public override void Dispose() => socket.Dispose();
    }

    /// <summary>A line of JSON with the bytes in Base64, each way, as many first programs do it.</summary>
    internal sealed class JsonLines : Contender
    {
        private readonly Socket socket;
        private readonly StreamReader reader;
        private readonly StreamWriter writer;

        public JsonLines(string endpoint, int size) : base(size)
        {
            socket = Tcp.Connected(endpoint);
            var stream = new NetworkStream(socket);
            (reader, writer) = (new StreamReader(stream),
                new StreamWriter(stream, new UTF8Encoding(false)) { AutoFlush = true, NewLine = "\n" });
        }

        public override void Send() => writer.WriteLine($"{{\"image\": \"{Convert.ToBase64String(Payload)}\"}}");

        public override void Receive()
        {
            var line = reader.ReadLine() ?? throw new IOException("the server hung up");
            Newtonsoft.Json.Linq.JObject.Parse(line);
            var start = line.IndexOf(": \"", StringComparison.Ordinal) + 3;
            var digits = line.Substring(start, line.LastIndexOf('"') - start);
            Check(Convert.FromBase64String(digits).Length == Payload.Length);
        }

        public override void Dispose() => socket.Dispose();
    }
}
