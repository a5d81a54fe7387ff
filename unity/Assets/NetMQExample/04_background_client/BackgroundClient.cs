// Lesson 04, the background client: frames go on while a thread of its own talks to the server.
//
//     client = new BackgroundClient("tcp://127.0.0.1:5554");                            once, in OnEnable
//     client.Request("hello", reply => Debug.Log(reply), why => Debug.LogError(why));   whenever you like
//     client.Poll();                                                                    in Update: callbacks run here
//     client.Dispose();                                                                 in OnDisable
//
// For await there is BackgroundClientAsync.cs. The Python side is python/04_background_client/server.py.
// Bytes: those of lesson 02, [id][text] each way. Its LazyPirateRequester sends and retries; this file has only the
// thread on which it may block, and the queues between that thread and yours.
// Trouble: --slow-on of the server, or no server at all. Update goes on, State and LastError say what is wrong, and
// each request ends in exactly one of its two callbacks.
// Cost: nothing is allocated on the main thread if you make the callbacks once and keep them in fields. Written as
// above, `reply => …` at the call, each request makes new objects, which is fine for a few requests a second.
using System;
using System.Collections.Concurrent;
using System.Collections.Generic;
using System.Runtime.ExceptionServices;
using System.Threading;
using Stopwatch = System.Diagnostics.Stopwatch;

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

    /// <summary>Asks a server without ever making the calling thread wait. Each client has its own thread. Any thread
    /// may ask; Poll and Dispose belong to one, in Unity the main thread.</summary>
    public sealed class BackgroundClient : IDisposable
    {
        private readonly ConcurrentQueue<(Delegate callback, string text, Exception why)> done = new();
        // With room for as many as may usually wait: to grow when the network is late would allocate memory in a frame.
        private readonly Queue<(string text, Action<string> reply, Delegate error)> waiting = new(64);
        // Guards `waiting`, whose head is the request that is being asked, and what is known.
        private readonly object gate = new object();
        // Not Monitor.Pulse: the woken thread would block on the gate, which Request still holds.
        private readonly AutoResetEvent wake = new AutoResetEvent(false);
        private readonly CancellationTokenSource stop = new CancellationTokenSource();
        private readonly Stopwatch clock = new Stopwatch();
        private readonly int capacity;
        private readonly string endpoint;
        private readonly Thread thread;
        private (ClientState state, string trouble) status = (ClientState.Connecting, "");
        private TimeSpan roundTrip;
        private int replies;
        private bool polled;

        /// <summary>Starts the network thread, and succeeds even while no server is there.</summary>
        /// <param name="endpoint">The server, such as <c>tcp://127.0.0.1:5554</c>.</param>
        /// <param name="timeout">How long the first try waits for its reply, 1 s when left out. Each try waits twice
        /// as long as the one before, at most 8 times as long as the first.</param>
        /// <param name="tries">How often a request is sent before it is given up.</param>
        /// <param name="capacity">How many requests may be under way; one more is refused.</param>
        /// <exception cref="ArgumentException">One of them cannot work; the message names cause and cure. An unknown
        /// host is the error of each request.</exception>
        public BackgroundClient(string endpoint, TimeSpan? timeout = null, int tries = 3, int capacity = 64)
        {
            // The host's name is looked up on the thread, since that may take its time.
            NetMQConnection.Host(endpoint);
            this.endpoint = endpoint;
            Require.Count("tries", tries);
            this.capacity = Require.Count("capacity", capacity);
            var first = Require.Seconds("timeout", timeout ?? TimeSpan.FromSeconds(1));
            thread = new Thread(() => Talk(endpoint, first, tries)) { IsBackground = true, Name = "BackgroundClient" };
            thread.Start();
        }

        /// <summary>Of one moment: the state, and why the last try that had no reply had none, which stays for a log.
        /// This and what follows can be read at any time.</summary>
        public (ClientState State, string Trouble) Status { get { lock (gate) return status; } }

        public ClientState State => Status.State;

        /// <summary>Why there is no reply now; an empty text while it is connected.</summary>
        public string LastError
        {
            get
            {
                var (state, trouble) = Status;
                return state == ClientState.Connected ? "" : trouble;
            }
        }

        /// <summary>How long the last reply took to come, with all its tries, or zero.</summary>
        public TimeSpan RoundTripTime { get { lock (gate) return roundTrip; } }

        public int Replies { get { lock (gate) return replies; } }
        private bool Stopped => stop.IsCancellationRequested;

        /// <summary>Sends a request, and has one of the two callbacks run once in a later <see cref="Poll"/>.</summary>
        /// <param name="text">The request, sent as UTF-8.</param>
        /// <param name="reply">Gets the reply's text. A text that begins with <c>error:</c> is a reply too.</param>
        /// <param name="error">Gets the reason why there is no reply.</param>
        /// <exception cref="ArgumentException">The text has more than 65,536 bytes.</exception>
        /// <returns>False if refused, because as many as have room are under way, or after Dispose: neither callback
        /// will run.</returns>
        public bool Request(string text, Action<string> reply, Action<string> error = null) =>
            Begin(text, reply, error);

        // `error` takes the reason, as a text or as an exception.
        internal bool Begin(string text, Action<string> reply, Delegate error)
        {
            Require.Text("text", text);
            lock (gate)
            {
                if (Stopped || waiting.Count + done.Count >= capacity) return false;
                waiting.Enqueue((text, reply, error));
            }
            wake.Set();
            return true;
        }

        public override string ToString() => $"BackgroundClient {endpoint}: {State}";

        /// <summary>Runs the callbacks of what has ended. Call it in Update. If a callback throws, the exception comes
        /// out here, and the callbacks after it run in the next Poll.</summary>
        public void Poll()
        {
            polled = true;
            // Only what is there now: callbacks that ask again must not make one frame last for ever.
            for (var left = done.Count; left > 0 && done.TryDequeue(out var next); left--)
                if (next.callback is Action<string> run) run(next.text);
                else (next.callback as Action<Exception>)?.Invoke(next.why);
        }

        /// <summary>Ends the thread, usually within 20 ms. Before it returns, the error callback of every request that
        /// has no reply yet has run; none runs later. Call it on the thread that calls <see cref="Poll"/>.</summary>
        public void Dispose()
        {
            stop.Cancel();
            wake.Set();
            // The limit is for what nobody foresaw, such as a slow look-up of a host name: Stop must never freeze
            // Unity.
            NetworkThread.Join(thread);
            lock (gate)
            {
                var why = "the client was disposed";
                if (status.state == ClientState.Retrying) why += $"; {status.trouble}";
                status.state = ClientState.Disposed;
                while (waiting.TryDequeue(out var call))
                    done.Enqueue((call.error, why, new ObjectDisposedException(null, why)));
            }
            Exception mistake = null;
            while (!done.IsEmpty)
                // After one that throws, the others run all the same.
                try { Poll(); }
                catch (Exception e) { mistake ??= e; }
            if (mistake != null) ExceptionDispatchInfo.Capture(mistake).Throw();
        }

        // From here on: the network thread. The requester is made, used and disposed here.
        private void Talk(string endpoint, TimeSpan timeout, int tries)
        {
            LazyPirateRequester pirate = null;
            while (!Stopped)
            {
                if (!TryNext(out var call)) continue;
                try
                {
                    // Here and not before: if NetMQ cannot be had, that too is the error of a request.
                    pirate ??= new LazyPirateRequester(endpoint, timeout, tries,
                        why => { lock (gate) if (!Stopped) status = (ClientState.Retrying, why); });
                    clock.Restart();
                    Finish(ClientState.Connected, call.reply, pirate.Request(call.text, stop.Token));
                }
                catch (OperationCanceledException) { /* Dispose ends what waits. */ }
                // Any exception ends in the error callback, and this thread goes on.
                catch (Exception e) { Finish(ClientState.Lost, call.error, LogText.Why(e), e); }
            }
            pirate?.Dispose();
        }

        private bool TryNext(out (string text, Action<string> reply, Delegate error) call)
        {
            lock (gate) if (waiting.TryPeek(out call)) return true;
            // Sleeps, which costs nothing, until Request or Dispose wakes it; a second, if that is how long nobody has
            // fetched the first reply.
            if (!wake.WaitOne(polled || done.IsEmpty ? Timeout.Infinite : 1000) && !polled)
            {
                polled = true;
#if UNITY_5_3_OR_NEWER
                UnityEngine.Debug.LogWarning("BackgroundClient: a reply waits, and nobody has called Poll: callbacks "
                    + "run only in there, so call it in Update");
#endif
            }
            // The system may have taken the processor from the main thread for this one: the frame goes first.
            Thread.Yield();
            return false;
        }

        private void Finish(ClientState state, Delegate callback, string text, Exception why = null)
        {
            lock (gate)
            {
                // If it is not there any more, Dispose has ended it.
                if (!waiting.TryDequeue(out _)) return;
                done.Enqueue((callback, text, why));
                if (state == ClientState.Lost)
                {
                    status = (state, text);
                    return;
                }
                status.state = state;
                roundTrip = clock.Elapsed;
                replies++;
            }
        }
    }
}
