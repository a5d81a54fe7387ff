// Lesson 04, the background client: frames go on while a thread of its own talks to the server.
//
//     client = new BackgroundClient("tcp://127.0.0.1:5554");                            once, in OnEnable
//     client.Request("hello", reply => Debug.Log(reply), why => Debug.LogError(why));   whenever you like
//     client.Poll();                                                                    in Update: callbacks run here
//     client.Dispose();                                                                 in OnDisable
//
// Take home: this file, LazyPirateRequester.cs (lesson 02), NetMQConnection.cs and NetMQLifetime.cs. For await there is
// BackgroundClientAsync.cs. The Python side is python/04_background_client/server.py.
// Bytes: those of lesson 02, [id][text] each way. Its LazyPirateRequester asks and asks again; here are only the thread
// that lets it wait, and the queues between that thread and yours.
// Trouble: --crash-on, --drop, --slow-on, --garbage-on and --half-on of the server, or no server at all. Update goes on
// in all of them, State and LastError say what is wrong, and each request ends in exactly one of its two callbacks.
// Cost: nothing is allocated on the main thread if you make the callbacks once and keep them in fields. Written as
// above, `reply => …` at the call, each request makes new objects, which is fine for a few requests a second.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Runtime.ExceptionServices;
using System.Text;
using System.Threading;

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

        // The gate guards what waits for a reply, the one that is asked now first, and what waits for Poll.
        private readonly object gate = new object();
        private readonly Queue<(string text, Action<string> reply, Action<string> error)> waiting;
        private readonly Queue<(Action<string> callback, string text)> done;
        // Not the gate's own signal: the woken thread would at once wait for the gate that the main thread still holds.
        private readonly AutoResetEvent wake = new AutoResetEvent(false);
        private readonly CancellationTokenSource stop = new CancellationTokenSource();
        private readonly Stopwatch clock = new Stopwatch();
        // Made once: a refusal must cost the main thread nothing either.
        private readonly string endpoint, full;
        private readonly TimeSpan patience;
        private readonly int tries, capacity;
        private readonly Thread thread;
        private LazyPirateRequester pirate;
        private (ClientState state, string lastError) status = (ClientState.Connecting, "");
        private TimeSpan roundTrip;
        private int replies;

        /// <summary>Starts the network thread, and succeeds even while no server is there.</summary>
        /// <param name="endpoint">The server, such as <c>tcp://127.0.0.1:5554</c>.</param>
        /// <param name="patience">How long the first try waits for its reply, 1 s when left out. Each try waits twice as
        /// long as the one before, at most 8 times as long as the first.</param>
        /// <param name="tries">How often a request is sent before it is given up.</param>
        /// <param name="capacity">How many requests may be under way; one more is refused.</param>
        public BackgroundClient(string endpoint, TimeSpan? patience = null, int tries = 3, int capacity = 64)
        {
            if (tries < 1 || capacity < 1) throw new ArgumentException("tries and capacity must be at least 1");
            (this.endpoint, this.tries, this.capacity) = (endpoint, tries, capacity);
            full = $"refused: {capacity} requests are under way already";
            this.patience = patience ?? TimeSpan.FromSeconds(1);
            waiting = new Queue<(string, Action<string>, Action<string>)>(capacity);
            done = new Queue<(Action<string>, string)>(capacity);
            thread = new Thread(Talk) { IsBackground = true, Name = nameof(BackgroundClient) };
            thread.Start();
        }

        /// <summary>State and LastError of one moment. This and what follows can be read at any time.</summary>
        public (ClientState State, string LastError) Status
        {
            get { lock (gate) return (Stopped ? ClientState.Disposed : status.state, status.lastError); }
        }

        /// <summary>What is known about the server.</summary>
        public ClientState State => Status.State;

        /// <summary>What went wrong last, or an empty text.</summary>
        public string LastError => Status.LastError;

        /// <summary>How long the last reply took to come, or zero.</summary>
        public TimeSpan RoundTripTime { get { lock (gate) return roundTrip; } }

        /// <summary>How many requests were answered.</summary>
        public int Replies { get { lock (gate) return replies; } }

        private bool Stopped => stop.IsCancellationRequested;

        /// <summary>Sends a request, and has one of the two callbacks run once in a later <see cref="Poll"/>.</summary>
        /// <param name="text">The request, sent as UTF-8.</param>
        /// <param name="reply">Gets the reply's text. A text that begins with <c>error:</c> is a reply too.</param>
        /// <param name="error">Gets the reason why there is no reply.</param>
        /// <returns>False if refused, because the client is full or disposed: neither callback will run, and
        /// <see cref="LastError"/> has the reason. While the server does not answer, that is its silence.</returns>
        public bool Request(string text, Action<string> reply, Action<string> error = null)
        {
            if (text == null) throw new ArgumentNullException(nameof(text));
            lock (gate)
            {
                if (Stopped || waiting.Count + done.Count >= capacity)
                {
                    // While the server is silent, that silence is the cause, and stays.
                    if (Stopped || status.state != ClientState.Retrying)
                        status.lastError = Stopped ? Ended : full;
                    return false;
                }
                waiting.Enqueue((text, reply, error));
            }
            wake.Set();
            return true;
        }

        /// <summary>Runs the callbacks of what has ended. Call it in Update. If a callback throws, the exception comes
        /// out here, and the callbacks after it run in the next Poll.</summary>
        public void Poll()
        {
            int left;
            // Only what is there now: callbacks that ask again must not make one frame last for ever.
            lock (gate) left = done.Count;
            while (left-- > 0 && TryNext(out var callback, out var text)) callback?.Invoke(text);
        }

        /// <summary>Ends the thread, usually within 20 ms. Before it returns, the error callback of every request that
        /// has no reply yet has run; none runs later. Call it on the thread that calls <see cref="Poll"/>.</summary>
        public void Dispose()
        {
            stop.Cancel();
            wake.Set();
            // The limit is for what nobody foresaw, such as a slow look-up of a host name: Stop must never freeze Unity.
            NetMQLifetime.Join(thread);
            lock (gate)
                while (waiting.TryDequeue(out var call)) done.Enqueue((call.error, Ended));
            ExceptionDispatchInfo first = null;
            while (TryNext(out var callback, out var text))
            {
                try { callback?.Invoke(text); }
                // The others run all the same.
                catch (Exception e) { first ??= ExceptionDispatchInfo.Capture(e); }
            }
            first?.Throw();
        }

        // A callback runs without the gate, because it may call Request, Poll and Dispose.
        private bool TryNext(out Action<string> callback, out string text)
        {
            lock (gate)
            {
                var found = done.TryDequeue(out var next);
                (callback, text) = next;
                return found;
            }
        }

        // From here on: the network thread. The requester is made, used and disposed here.
        private void Talk()
        {
            while (!Stopped)
            {
                var call = Next();
                try
                {
                    if (call.text != null) Finish(ClientState.Connected, call.reply, Ask(call.text));
                }
                catch (NoReplyException e) { Finish(ClientState.Lost, call.error, Trouble(e)); }
                catch (OperationCanceledException) { /* Dispose ends what waits. */ }
                catch (Exception e)
                {
                    // Whatever it is, this thread goes on, and the caller gets to know.
                    Close();
                    Finish(ClientState.Lost, call.error, NetMQLifetime.Why(e));
                }
            }
            Close();
        }

        // What is asked next; with no text if there is nothing.
        private (string text, Action<string> reply, Action<string> error) Next()
        {
            lock (gate)
                if (waiting.TryPeek(out var call)) return call;
            // Sleeps, which costs nothing, until Request or Dispose wakes it.
            wake.WaitOne();
            // The system may have taken the processor from the main thread for this one: the frame goes first.
            Thread.Yield();
            return default;
        }

        private string Ask(string text)
        {
            if (Encoding.UTF8.GetByteCount(text) > MaxBytes)
                throw new ArgumentException($"a text has at most {MaxBytes} bytes");
            // Here and not in Talk: if NetMQ cannot be had, that too is the error of a request.
            pirate ??= new LazyPirateRequester(endpoint, patience, tries, Retry);
            clock.Restart();
            return pirate.Request(text, stop.Token);
        }

        private void Retry(NoReplyException e)
        {
            lock (gate) status = (ClientState.Retrying, Trouble(e));
            clock.Restart();
        }

        private string Trouble(NoReplyException e)
        {
            var seconds = FormattableString.Invariant($"{e.Limit.TotalSeconds} s");
            return (e.Wrong
                ? $"garbage from {endpoint}: not [id][text] in two frames; is it the right server?"
                : $"no reply from {endpoint} within {seconds}; is the server running, or the line slow?")
                + $" (try {e.Attempt} of {tries})";
        }

        private void Finish(ClientState state, Action<string> callback, string text)
        {
            lock (gate)
            {
                // If it is not there any more, Dispose has ended it.
                if (!waiting.TryDequeue(out _)) return;
                done.Enqueue((callback, text));
                status = (state, state == ClientState.Lost ? text : status.lastError);
                if (state != ClientState.Connected) return;
                replies++;
                roundTrip = clock.Elapsed;
            }
        }

        private void Close()
        {
            try { pirate?.Dispose(); }
            catch (Exception) { /* Somebody called NetMQConfig.Cleanup, and the socket went with it. */ }
            pirate = null;
        }
    }
}
