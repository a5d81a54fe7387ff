// Lesson 04, the background client: frames go on while a thread of its own talks to the server.
//
//     client = new BackgroundClient("tcp://127.0.0.1:5554");                            once, in OnEnable
//     client.Request("hello", reply => Debug.Log(reply), why => Debug.LogError(why));   whenever you like
//     client.Poll();                                                                    in Update: callbacks run here
//     client.Dispose();                                                                 in OnDisable
//
// Take home: this file and NetMQLifetime.cs (lesson 01). The Python side is python/04_background_client/server.py.
// Bytes: a request is two frames, [id][text], and so is its reply; all UTF-8. The client makes the id, a new one for
// each request and the same one for its retries, so that the server does nothing twice (lesson 02).
// Trouble: --crash-on, --drop, --slow-on, --garbage-on and --half-on of the server, or no server at all. Update goes on
// in all of them, State and LastError say what is wrong, and each request ends in exactly one of its two callbacks.
// Cost: nothing is allocated on the main thread if you make the callbacks once and keep them in fields. Written as
// above, `reply => …` at the call, each request makes new objects, which is fine for a few requests a second.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.IO;
using System.Text;
using System.Threading;
using System.Threading.Tasks;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample
{
    /// <summary>What is known about the server. Only a reply proves that it is there.</summary>
    public enum ClientState
    {
        /// <summary>No request has been answered or given up yet.</summary>
        Connecting,
        /// <summary>The last request was answered.</summary>
        Connected,
        /// <summary>A try was in vain; the request is sent again.</summary>
        Retrying,
        /// <summary>The last request was given up. The next one tries anew.</summary>
        Lost,
        /// <summary>After Dispose.</summary>
        Disposed,
    }

    /// <summary>Asks a server without ever making the calling thread wait. Each client has its own thread.</summary>
    public sealed class BackgroundClient : IDisposable
    {
        private const string Ended = "the client was disposed";
        private const int MaxBytes = 65536;
        // How long a wait for the network lasts before it looks whether to stop. Ten clients stop one after the other.
        private static readonly TimeSpan Slice = TimeSpan.FromMilliseconds(10);

        // The gate guards what waits for a reply, the one that is asked now first, and what waits for Poll.
        private readonly object gate = new object();
        private readonly Queue<(string text, Action<string> reply, Action<string> error)> waiting;
        private readonly Queue<(Action<string> callback, string text)> done;
        // Not the gate's own signal: the woken thread would at once wait for the gate that the main thread still holds.
        private readonly AutoResetEvent wake = new AutoResetEvent(false);
        private volatile bool stopped;

        private readonly string endpoint, name = Guid.NewGuid().ToString("N");
        private readonly TimeSpan patience;
        private readonly int tries, capacity;
        private readonly Thread thread;
        private NetMQLifetime lifetime;
        private RequestSocket socket;
        private long asked, roundTrip;
        private volatile int replies;
        private (ClientState state, string lastError) status = (ClientState.Connecting, "");

        /// <summary>Starts the network thread, and succeeds even while no server is there.</summary>
        /// <param name="endpoint">The server, such as <c>tcp://127.0.0.1:5554</c>.</param>
        /// <param name="patience">How long the first try waits for its reply, 1 s when left out. The second waits twice as
        /// long, all others four times: on a far line the connection alone takes four round trips.</param>
        /// <param name="tries">How often a request is sent before it is given up.</param>
        /// <param name="capacity">How many requests may be under way; one more is refused.</param>
        public BackgroundClient(string endpoint, TimeSpan? patience = null, int tries = 3, int capacity = 64)
        {
            if (tries < 1 || capacity < 1) throw new ArgumentException("tries and capacity must be at least 1");
            (this.endpoint, this.tries, this.capacity) = (endpoint, tries, capacity);
            this.patience = patience ?? TimeSpan.FromSeconds(1);
            waiting = new Queue<(string, Action<string>, Action<string>)>(capacity);
            done = new Queue<(Action<string>, string)>(capacity);
            thread = new Thread(Talk) { IsBackground = true, Name = nameof(BackgroundClient) };
            thread.Start();
        }

        /// <summary>State and LastError of one moment. This and what follows can be read at any time.</summary>
        public (ClientState State, string LastError) Status
        {
            get { lock (gate) return (stopped ? ClientState.Disposed : status.state, status.lastError); }
        }

        /// <summary>What is known about the server.</summary>
        public ClientState State => Status.State;

        /// <summary>What went wrong last, or an empty text.</summary>
        public string LastError => Status.LastError;

        /// <summary>How long the last reply took to come, or zero.</summary>
        public TimeSpan RoundTripTime => TimeSpan.FromTicks(Interlocked.Read(ref roundTrip));

        /// <summary>How many requests were answered.</summary>
        public int Replies => replies;

        /// <summary>Sends a request, and has one of the two callbacks run once in a later <see cref="Poll"/>.</summary>
        /// <param name="text">The request, sent as UTF-8.</param>
        /// <param name="reply">Gets the reply's text. A text that begins with <c>error:</c> is a reply too.</param>
        /// <param name="error">Gets the reason why there is no reply.</param>
        /// <returns>False if refused, because the client is full or disposed: neither callback will run, and
        /// <see cref="LastError"/> has the reason. While the server does not answer, that is its silence.</returns>
        public bool Request(string text, Action<string> reply, Action<string> error = null)
        {
            lock (gate)
            {
                if (stopped || waiting.Count + done.Count >= capacity)
                {
                    // While the server is silent, that silence is the cause, and stays.
                    if (stopped || status.state != ClientState.Retrying)
                        status.lastError = stopped ? Ended : $"refused: {capacity} requests are under way already";
                    return false;
                }
                waiting.Enqueue((text, reply, error));
            }
            wake.Set();
            return true;
        }

        /// <summary>The same to await. Its task ends inside <see cref="Poll"/>, and what awaits it goes on there.</summary>
        /// <param name="text">The request, sent as UTF-8.</param>
        /// <returns>The reply's text, or an <see cref="IOException"/> with the reason why there is none.</returns>
        public Task<string> RequestAsync(string text)
        {
            // Not RunContinuationsAsynchronously: that would go on in a thread of the pool.
            var answer = new TaskCompletionSource<string>();
            Action<string> error = why => answer.SetException(new IOException(why));
            if (!Request(text, answer.SetResult, error)) error(LastError);
            return answer.Task;
        }

        /// <summary>Runs the callbacks of what has ended. Call it in Update. If a callback throws, the exception comes
        /// out here, and the callbacks after it run in the next Poll.</summary>
        public void Poll()
        {
            // Only what is there now: callbacks that ask again must not make one frame last for ever. Read without the
            // gate, the number may be too small; what came this very moment is there in the next frame.
            for (var left = done.Count; left > 0; left--)
            {
                (Action<string> callback, string text) next;
                lock (gate) done.TryDequeue(out next);
                // Without the gate, because it may call Request, Poll and Dispose.
                next.callback?.Invoke(next.text);
            }
        }

        /// <summary>Ends the thread, usually within 20 ms. Before it returns, the error callback of every request that
        /// has no reply yet has run; none runs later. Call it on the thread that calls <see cref="Poll"/>.</summary>
        public void Dispose()
        {
            stopped = true;
            wake.Set();
            // The limit is for what nobody foresaw, such as a slow look-up of a host name: Stop must never freeze Unity.
            NetMQLifetime.Join(thread);
            lock (gate)
            {
                while (waiting.TryDequeue(out var call)) done.Enqueue((call.error, Ended));
            }
            try { Poll(); }
            // A callback threw: the others run all the same.
            finally { if (done.Count > 0) Dispose(); }
        }

        private void Finish(ClientState state, Action<string> callback, string text)
        {
            lock (gate)
            {
                // If it is not there any more, Dispose has ended it.
                if (!waiting.TryDequeue(out _)) return;
                done.Enqueue((callback, text));
                if (state == ClientState.Connected) replies++;
                status = (state, state == ClientState.Lost ? text : status.lastError);
            }
        }

        // From here on: the network thread. The socket is made, used and disposed here.
        private void Talk()
        {
            while (!stopped)
            {
                (string text, Action<string> reply, Action<string> error) call;
                bool found;
                lock (gate) found = waiting.TryPeek(out call);
                if (!found)
                {
                    // Sleeps, which costs nothing, until Request or Dispose wakes it.
                    wake.WaitOne();
                    // The system may have taken the processor from the main thread for this one: the frame goes first.
                    Thread.Yield();
                    continue;
                }
                try
                {
                    Finish(ClientState.Connected, call.reply, Ask(call.text));
                }
                catch (Exception e)
                {
                    // Whatever it is, this thread goes on, and the caller gets to know.
                    Close();
                    Finish(ClientState.Lost, call.error, NetMQLifetime.Why(e));
                }
            }
            Close();
            lifetime?.Dispose();
        }

        private string Ask(string text)
        {
            if (Encoding.UTF8.GetByteCount(text) > MaxBytes) throw new ArgumentException($"a text has at most {MaxBytes} bytes");
            var id = $"{name}-{++asked}";
            for (var attempt = 1; ; attempt++)
            {
                if (socket == null) Open();
                var (reply, failure) = Try(id, text, patience * (attempt < 3 ? attempt : 4));
                if (failure == null) return reply;
                // A REQ socket that waits for a reply takes no other request. A new one also never gets a late reply.
                Close();
                failure = $"{failure} (try {attempt} of {tries})";
                if (attempt == tries) throw new TimeoutException(failure);
                lock (gate) status = (ClientState.Retrying, failure);
            }
        }

        private (string reply, string failure) Try(string id, string text, TimeSpan limit)
        {
            List<string> frames = null;
            var waited = Stopwatch.StartNew();
            // After an error of the peer's, a socket has no connection left, and sends nothing: the next one will.
            var sent = socket.TrySendFrame(Slice, id, more: true) && socket.TrySendFrame(Slice, text);
            while (!sent || !socket.TryReceiveMultipartStrings(Slice, ref frames))
            {
                if (stopped) throw new OperationCanceledException(Ended);
                if (!sent || waited.Elapsed >= limit)
                    return (null, FormattableString.Invariant(
                        $"no reply from {endpoint} within {limit.TotalSeconds} s; is the server running, or the line slow?"));
            }
            if (frames.Count != 2 || frames[0] != id)
                return (null, $"garbage from {endpoint}: not [id][text] in two frames; is it the right server?");
            Interlocked.Exchange(ref roundTrip, waited.Elapsed.Ticks);
            return (frames[1], null);
        }

        private void Open()
        {
            // Here and not in Talk: if NetMQ cannot be had, that too is the error of a request.
            lifetime ??= new NetMQLifetime();
            // A request that nobody fetched is dropped on Dispose; waiting for its delivery could take for ever.
            socket = new RequestSocket { Options = { Linger = TimeSpan.Zero, MaxMsgSize = MaxBytes } };
            NetMQLifetime.Connect(socket, endpoint);
        }

        private void Close()
        {
            try { socket?.Dispose(); }
            catch (Exception) { /* Somebody called NetMQConfig.Cleanup, and the socket went with it. */ }
            socket = null;
        }
    }
}
