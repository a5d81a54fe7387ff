// Contenders without ZeroMQ: over a plain TCP socket the limit, and what people write first; and those of the web, with
// .NET's own clients.
using System;
using System.IO;
using System.Net;
using System.Net.Http;
using System.Net.Sockets;
using System.Net.WebSockets;
using System.Text;
using System.Threading;
using System.Threading.Tasks;
using static NetMQExample.Lab.Contender;

namespace NetMQExample.Lab
{
    internal static class Plain
    {
        // The limit: four bytes of length, then the payload, in buffers that are made once.
        public static Contender Tcp(string endpoint, byte[] payload)
        {
            var socket = Connected(endpoint);
            byte[] outgoing = new byte[4 + payload.Length], incoming = new byte[4 + payload.Length];
            BitConverter.GetBytes(payload.Length).CopyTo(outgoing, 0);
            payload.CopyTo(outgoing, 4);
            return new Contender(socket, () =>
            {
                for (var sent = 0; sent < outgoing.Length;)
                    sent += socket.Send(outgoing, sent, outgoing.Length - sent, SocketFlags.None);
                for (var received = 0; received < incoming.Length;)
                {
                    var some = socket.Receive(incoming, received, incoming.Length - received, SocketFlags.None);
                    if (some == 0) throw new IOException("the server hung up");
                    received += some;
                }
                Check(incoming[0] == (byte)payload.Length && incoming[^1] == outgoing[^1]);
            });
        }

        // A line of JSON with the bytes in Base64, each way, as many first programs do it.
        public static Contender JsonLines(string endpoint, byte[] payload)
        {
            var socket = Connected(endpoint);
            var stream = new NetworkStream(socket);
            var reader = new StreamReader(stream);
            var writer = new StreamWriter(stream, new UTF8Encoding(false)) { AutoFlush = true, NewLine = "\n" };
            return new Contender(socket, () =>
            {
                writer.WriteLine($"{{\"image\": \"{Convert.ToBase64String(payload)}\"}}");
                var line = reader.ReadLine() ?? throw new IOException("the server hung up");
                Newtonsoft.Json.Linq.JObject.Parse(line);
                var start = line.IndexOf(": \"", StringComparison.Ordinal) + 3;
                var digits = line.Substring(start, line.LastIndexOf('"') - start);
                Check(Convert.FromBase64String(digits).Length == payload.Length);
            });
        }

        // POST with keep-alive, with the payload as its body.
        public static Contender Http(string endpoint, byte[] payload)
        {
            var client = new HttpClient { Timeout = Limit };
            var address = endpoint.Replace("tcp:", "http:");
            async Task<byte[]> Post()
            {
                using var response =
                    await client.PostAsync(address, new ByteArrayContent(payload)).ConfigureAwait(false);
                return await response.Content.ReadAsByteArrayAsync().ConfigureAwait(false);
            }
            return new Contender(client, () => Check(Post().GetAwaiter().GetResult().Length == payload.Length));
        }

        // One binary message each way.
        public static Contender WebSocket(string endpoint, byte[] payload)
        {
            var socket = new ClientWebSocket();
            var never = CancellationToken.None;
            var incoming = new byte[payload.Length];
            socket.ConnectAsync(new Uri(endpoint.Replace("tcp:", "ws:")), never).Wait(Limit);
            return new Contender(socket, () =>
            {
                socket.SendAsync(new ArraySegment<byte>(payload), WebSocketMessageType.Binary, true, never)
                    .GetAwaiter().GetResult();
                var received = 0;
                for (var end = false; !end;)
                {
                    var room = new ArraySegment<byte>(incoming, received, incoming.Length - received);
                    var part = socket.ReceiveAsync(room, never).GetAwaiter().GetResult();
                    received += part.Count;
                    end = part.EndOfMessage;
                }
                Check(received == payload.Length);
            });
        }

        private static Socket Connected(string endpoint)
        {
            var address = new Uri(endpoint);
            var socket = new Socket(AddressFamily.InterNetwork, SocketType.Stream, ProtocolType.Tcp)
            {
                NoDelay = true,
                ReceiveTimeout = (int)Limit.TotalMilliseconds,
            };
            socket.Connect(IPAddress.Parse(address.Host), address.Port);
            return socket;
        }
    }
}
