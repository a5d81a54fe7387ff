// Lesson 16 over Socket.IO, protocol 5, by hand: what a client needs of it are five kinds of text messages. They begin
// with digits: Engine.IO's, which only carries, then Socket.IO's.
//
//     0{…}   the connection is there         40{"token":…}   we want to come in      40{…}   yes    44{…}   no
//     421["hello","Hello"]   event 1         431["World"]   the reply to event 1
//     2   are you there?                     3   yes
using System;
using Newtonsoft.Json;
using Newtonsoft.Json.Linq;

namespace NetMQExample
{
    /// <summary>The connection is to the gateway, and the name of each event says to which server behind it.</summary>
    public sealed class SocketIORequester : WebRequester
    {
        private readonly string name, token;
        private bool ready;
        private int number;

        /// <inheritdoc cref="WebRequester(string, TimeSpan?)"/>
        public SocketIORequester(string endpoint, string name, string token = "", TimeSpan? timeout = null)
            : base(endpoint, timeout)
        {
            this.name = WebText.Given("name", name);
            this.token = WebText.Given("token", token);
        }

        protected override string Path => "/socket.io/?EIO=4&transport=websocket";
        protected override bool IsReady => ready;

        protected override string Write(string[] frames) =>
            FormattableString.Invariant($"42{++number}") + new JArray(name, frames).ToString(Formatting.None);

        protected override void Read(string text)
        {
            var reply = FormattableString.Invariant($"43{number}");
            bool Begins(string with) => text.StartsWith(with, StringComparison.Ordinal);
            if (Begins("0")) Say("40" + new JObject { ["token"] = token }.ToString(Formatting.None));
            else if (Begins("40")) ready = true;
            // It says why: with another reason than that one it may let us in later.
            else if (Begins("44") && text.Contains("token")) throw Refused();
            else if (Begins("44")) Again(text.Substring(2));
            else if (text == "2") Say("3");
            else if (Begins(reply + "["))
            {
                var frames = WebText.Parse(text.Substring(reply.Length));
                // In place of frames there may be one object, which says why there are none.
                Answer(frames.First as JObject ?? frames);
            }
        }

        protected override void Forget() => ready = false;
    }
}
