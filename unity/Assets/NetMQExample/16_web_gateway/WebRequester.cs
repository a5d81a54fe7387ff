// Asks one of the servers behind the gateway, without ever waiting: what WebSocket and Socket.IO have in common.
//
//     using var requester = new WebSocketRequester("http://127.0.0.1:5566", "hello");
//     requester.Ask("Hello");
//     if (requester.TryReceive(out var frames)) …           once a frame, until it is true
//
// They need Newtonsoft.Json, and neither NetMQ nor a thread. The Python side is python/16_web_gateway/server.py.
using System;
using System.Diagnostics;
using System.IO;
using System.Linq;
using System.Text.RegularExpressions;
using Newtonsoft.Json.Linq;

namespace NetMQExample
{
    /// <summary>One request at a time, each with a limit. A try that fails is followed by one on a new connection, and
    /// the request is sent again; whether it was done already only an id can tell, as in lesson 02. Use it on
    /// one thread, in Unity the main thread: it never waits.</summary>
    public abstract class WebRequester : IDisposable
    {
        private static readonly TimeSpan Pause = TimeSpan.FromSeconds(0.1);
        private readonly Stopwatch waited = new Stopwatch(), sinceTrouble = new Stopwatch();
        private readonly string endpoint;
        private readonly TimeSpan timeout;
        private IWebConnection connection;
        private string[] asked, answer;
        private string trouble = "is the server running?";
        private bool sent, disposed;

        /// <summary>Connects with the first request.</summary>
        /// <param name="endpoint">The gateway, such as <c>http://127.0.0.1:5566</c>.</param>
        /// <param name="timeout">How long to wait for each reply; 2.5 s when left out.</param>
        /// <exception cref="ArgumentException">One of them cannot work; the message names cause and cure.</exception>
        protected WebRequester(string endpoint, TimeSpan? timeout = null)
        {
            var parts = Regex.Match(endpoint ?? "", @"^https?://[^\s:/]+:([0-9]+)$");
            if (!ushort.TryParse(parts.Groups[1].Value, out var port) || port == 0)
                throw new ArgumentException(
                    $"bad endpoint '{endpoint}': write it like http://127.0.0.1:PORT, PORT from 1 to 65535");
            this.endpoint = endpoint;
            this.timeout = timeout ?? TimeSpan.FromSeconds(2.5);
            if (this.timeout <= TimeSpan.Zero || this.timeout > TimeSpan.FromDays(1))
                throw new ArgumentException(FormattableString.Invariant(
                    $"timeout must be more than 0 s and at most a day, not {this.timeout.TotalSeconds}"));
        }

        /// <summary>The one place that knows both kinds.</summary>
        /// <param name="endpoint">The gateway, such as <c>http://127.0.0.1:5566</c>.</param>
        /// <param name="name">The server behind it, such as hello.</param>
        /// <param name="socketIO">By Socket.IO in place of plain WebSocket.</param>
        /// <param name="token">The word that the gateway was given as --token.</param>
        /// <param name="timeout">How long to wait for each reply; 2.5 s when left out.</param>
        /// <exception cref="ArgumentException">One of them cannot work; the message names cause and cure.</exception>
        public static WebRequester To(string endpoint, string name, bool socketIO = false, string token = "",
            TimeSpan? timeout = null)
        {
            if (socketIO) return new SocketIORequester(endpoint, name, token, timeout);
            return new WebSocketRequester(endpoint, name, token, timeout);
        }

        /// <summary>Where the gateway listens for this kind, behind its <c>ws://host:port</c>.</summary>
        protected abstract string Path { get; }

        /// <summary>Asks. The reply to an earlier request is not waited for any more.</summary>
        /// <param name="frames">The frames of the request, sent as UTF-8.</param>
        public void Ask(params string[] frames)
        {
            // The one that comes next could be that of an earlier request.
            if (sent && answer == null) Close();
            asked = frames;
            answer = null;
            sent = false;
            waited.Restart();
        }

        /// <summary>Looks whether the reply has come. Call it once a frame until it has.</summary>
        /// <returns>False if it has not, and after Dispose.</returns>
        /// <exception cref="TimeoutException">It has not come in time.</exception>
        /// <exception cref="IOException">The gateway does not let this client in.</exception>
        public bool TryReceive(out string[] frames)
        {
            frames = null;
            if (disposed) return false;
            if (connection?.Closed is string why) Again(why);
            // After any trouble it waits a moment.
            var calm = !sinceTrouble.IsRunning || sinceTrouble.Elapsed > Pause;
            if (connection == null && calm)
                connection = Connect("ws" + endpoint.Substring(4) + Path);
            while (connection != null && answer == null && connection.TryReceive(out var text)) Read(text);
            if (answer == null && !sent && calm && connection?.IsOpen == true && IsReady)
            {
                sent = true;
                Say(Write(asked));
            }
            if (answer == null && waited.Elapsed > timeout) throw Late();
            frames = answer;
            return frames != null;
        }

        public override string ToString() => $"{GetType().Name} {endpoint}";

        /// <summary>Leaves at once, and does not come again.</summary>
        public void Dispose()
        {
            disposed = true;
            Close();
        }

        /// <summary>Whether a request may be sent as soon as the connection is open.</summary>
        protected virtual bool IsReady => true;

        /// <summary>Writes a request.</summary>
        protected abstract string Write(string[] frames);

        /// <summary>Reads a message, and hands a reply to <see cref="Answer"/>.</summary>
        protected abstract void Read(string text);

        /// <summary>Forgets what belongs to a connection that is gone.</summary>
        protected virtual void Forget() { }

        /// <summary>Sends a message.</summary>
        protected void Say(string text) => connection.Send(text);

        /// <summary>The reply has come.</summary>
        /// <param name="reply">A list of frames, or an object that says as <c>error</c> why there is none.</param>
        protected void Answer(JToken reply)
        {
            if (reply is JArray list && list.All(each => each.Type == JTokenType.String))
            {
                answer = list.ToObject<string[]>();
                return;
            }
            // The server behind is away: the connection will do for the next try.
            trouble = WebText.Printable($"{(reply as JObject)?["error"] ?? WebText.NoGateway}");
            sent = false;
            sinceTrouble.Restart();
        }

        /// <summary>No timeout would help.</summary>
        /// <returns>What to throw: GaveUpException is in Shared, which a build for the browser does not have.</returns>
        protected IOException Refused()
        {
            Close();
            return new IOException($"{endpoint} does not let this client in: its token is missing or wrong");
        }

        // The one place that knows where it runs.
        private static IWebConnection Connect(string address) =>
#if UNITY_WEBGL && !UNITY_EDITOR
            new BrowserConnection(address);
#else
            new DotNetConnection(address);
#endif

        private TimeoutException Late()
        {
            Close();
            return new TimeoutException(FormattableString.Invariant(
                $"no reply from {endpoint} within {timeout.TotalSeconds} s; {trouble}"));
        }

        /// <summary>A new connection, a moment later.</summary>
        protected void Again(string why)
        {
            if (why.Contains("403")) throw Refused();
            trouble = $"is the server running? ({WebText.Printable(why)})";
            Close();
            sinceTrouble.Restart();
        }

        private void Close()
        {
            connection?.Dispose();
            connection = null;
            sent = false;
            Forget();
        }
    }

    /// <summary>A WebSocket that carries text. It is looked at once a frame, and nothing of it waits: a browser has no
    /// second thread.</summary>
    public interface IWebConnection : IDisposable
    {
        /// <summary>True from the moment at which the gateway has let us in, until either side leaves.</summary>
        bool IsOpen { get; }

        /// <summary>Why it is closed; null while it is open, or about to be.</summary>
        string Closed { get; }

        /// <summary>Sends a message; what can no longer be sent is dropped.</summary>
        void Send(string text);

        /// <summary>Takes a message that has come.</summary>
        bool TryReceive(out string text);
    }
}
