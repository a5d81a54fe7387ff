// Contenders of the web: HTTP with keep-alive, and WebSocket, with .NET's own clients.
using System;
using System.Net.Http;
using System.Net.WebSockets;
using System.Text;
using System.Threading;
using System.Threading.Tasks;

namespace NetMQExample.Lab
{
    /// <summary>POST, with the payload as its body.</summary>
    internal sealed class Http : Contender
    {
        private readonly HttpClient client = new HttpClient { Timeout = Timeout };
        private readonly string address;
        private Task<byte[]> answer;

        public Http(string endpoint, int size) : base(size) => address = endpoint.Replace("tcp:", "http:");

        public override void Send() => answer = Post();

        public override void Receive() => Check(answer.GetAwaiter().GetResult().Length == Payload.Length);

        public override void Dispose() => client.Dispose();

        private async Task<byte[]> Post()
        {
            using var response = await client.PostAsync(address, new ByteArrayContent(Payload)).ConfigureAwait(false);
            return await response.Content.ReadAsByteArrayAsync().ConfigureAwait(false);
        }
    }

    /// <summary>One binary message each way.</summary>
    internal sealed class WebSockets : Contender
    {
        private readonly ClientWebSocket socket = new ClientWebSocket();
        private readonly byte[] incoming;
        private readonly CancellationToken never = CancellationToken.None;

        public WebSockets(string endpoint, int size) : base(size)
        {
            incoming = new byte[size];
            socket.ConnectAsync(new Uri(endpoint.Replace("tcp:", "ws:")), never).Wait(Timeout);
        }

        public override void Send() => socket.SendAsync(new ArraySegment<byte>(Payload), WebSocketMessageType.Binary, true, never).GetAwaiter().GetResult();

        public override void Receive()
        {
            var received = 0;
            for (var end = false; !end;)
            {
                var part = socket.ReceiveAsync(new ArraySegment<byte>(incoming, received, incoming.Length - received), never).GetAwaiter().GetResult();
                received += part.Count;
                end = part.EndOfMessage;
            }
            Check(received == Payload.Length);
        }

        public override void Dispose() => socket.Dispose();
    }

    /// <summary>Lesson 01 by the gateway of lesson 16: the messages of its requesters, which a game would look for once a
    /// frame, as fast as they come.</summary>
    internal sealed class Gateway : Contender
    {
        private readonly ClientWebSocket socket = new ClientWebSocket();
        private readonly byte[] incoming = new byte[1024];
        private readonly CancellationToken never = CancellationToken.None;
        private readonly bool socketIO;
        private readonly string text;
        private int number;

        public Gateway(string endpoint, int size, bool socketIO) : base(size)
        {
            (this.socketIO, text) = (socketIO, "Hello".PadRight(size));
            var path = socketIO ? "/socket.io/?EIO=4&transport=websocket" : "/ws/hello";
            socket.ConnectAsync(new Uri(endpoint.Replace("http:", "ws:") + path), never).Wait(Timeout);
            if (!socketIO) return;
            Next();
            Say("40");
            Next();
        }

        public override void Send() => Say(socketIO ? $"42{++number}[\"hello\",\"{text}\"]" : $"[\"{text}\"]");

        public override void Receive()
        {
            var said = Next();
            // Are you there?
            for (; socketIO && said == "2"; said = Next()) Say("3");
            Check(said == (socketIO ? $"43{number}[\"World\"]" : "[\"World\"]"));
        }

        public override void Dispose() => socket.Dispose();

        private void Say(string said) => socket.SendAsync(new ArraySegment<byte>(Encoding.UTF8.GetBytes(said)), WebSocketMessageType.Text, true, never).GetAwaiter().GetResult();

        private string Next() => Encoding.UTF8.GetString(incoming, 0, socket.ReceiveAsync(new ArraySegment<byte>(incoming), never).GetAwaiter().GetResult().Count);
    }
}
