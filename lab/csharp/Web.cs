// Contenders of the web: HTTP with keep-alive, and WebSocket, with .NET's own clients.
using System;
using System.Net.Http;
using System.Net.WebSockets;
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

        public override void Send() =>
            socket.SendAsync(new ArraySegment<byte>(Payload), WebSocketMessageType.Binary, true, never).GetAwaiter()
                .GetResult();

        public override void Receive()
        {
            var received = 0;
            for (var end = false; !end;)
            {
                var part =
                    socket.ReceiveAsync(new ArraySegment<byte>(incoming, received, incoming.Length - received), never)
                        .GetAwaiter().GetResult();
                received += part.Count;
                end = part.EndOfMessage;
            }
            Check(received == Payload.Length);
        }

        public override void Dispose() => socket.Dispose();
    }
}
