// Lesson 16 over plain WebSocket: a request is one message, a JSON list of its frames, and so is its reply.
using System;
using Newtonsoft.Json;

namespace NetMQExample
{
    /// <summary>The connection is to one server behind the gateway, and its address says to which.</summary>
    public sealed class WebSocketRequester : WebRequester
    {
        /// <inheritdoc cref="WebRequester(string, TimeSpan?)"/>
        public WebSocketRequester(string endpoint, string name, string token = "", TimeSpan? timeout = null)
            : base(endpoint, timeout) =>
            Path = $"/ws/{WebText.Given("name", name)}?token={Uri.EscapeDataString(WebText.Given("token", token))}";

        protected override string Path { get; }

        protected override string Write(string[] frames) => JsonConvert.SerializeObject(frames);
        protected override void Read(string text) => Answer(WebText.Parse(text));
    }
}
