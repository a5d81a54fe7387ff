// One check of BackgroundClient per run: dotnet background_client.dll CHECK ENDPOINT. The test has the server.
//
// Prints what happened, and ends with "ok"; ends with 1 and "failed: …" at the first thing that is wrong.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.IO;
using System.Linq;
using System.Reflection;
using System.Threading;
using System.Threading.Tasks;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample.Tests
{
    internal static class BackgroundClientChecks
    {
        private static readonly TimeSpan Limit = TimeSpan.FromSeconds(30);

        public static int Run(string[] words)
        {
            try
            {
                var checks = new Dictionary<string, Action<string>>
                {
                    ["refusal"] = Refusal,
                    ["stop"] = Stop,
                    ["stop-answered"] = StopAnswered,
                    ["look-up"] = LookUp,
                    ["stuck"] = Stuck,
                    ["one-after-another"] = OneAfterAnother,
                    ["why"] = Why,
                    ["forgotten"] = Forgotten,
                    ["many"] = Many,
                    ["await"] = Await,
                    ["throwing"] = Throwing,
                    ["nested"] = Nested,
                    ["cleanup"] = Cleanup,
                    ["state"] = State,
                    ["asleep"] = Asleep,
                    ["never-polled"] = NeverPolled,
                    ["allocates-nothing"] = AllocatesNothing,
                    ["random"] = Randomly,
                    ["pairs"] = Pairs,
                    ["too-long"] = TooLong,
                    ["no-socket"] = NoSocket,
                    ["listener-stops"] = ListenerStops,
                };
                checks[words[0]](words[1]);
                Console.WriteLine("ok");
                return 0;
            }
            catch (Exception e)
            {
                Console.WriteLine($"failed: {e}");
                return 1;
            }
        }

        private static void Check(bool right, string what)
        {
            if (!right) throw new InvalidOperationException(what);
        }

        private static void Equal<T>(T expected, T actual) => Check(Equals(expected, actual), $"expected {expected}, got {actual}");

        // Frames until something is true.
        private static void Until(Func<bool> condition, params BackgroundClient[] clients)
        {
            for (var waited = Stopwatch.StartNew(); !condition(); Thread.Sleep(1))
            {
                Check(waited.Elapsed < Limit, "took too long: " + string.Join("; ", clients.Select(c => $"{c.State} {c.LastError}")));
                foreach (var client in clients) client.Poll();
            }
        }

        // It waits 200 ms at the most, and later only where a busy machine has no core for it. Where nobody
        // answers the timeout is longer than this limit, which so tells a Dispose that waits for it from one that does not.
        private static void StopInTime(BackgroundClient client, int limit = 5000)
        {
            var took = Stopwatch.StartNew();
            client.Dispose();
            Check(took.ElapsedMilliseconds < limit, $"Dispose took {took.ElapsedMilliseconds} ms");
            Console.WriteLine($"stopped in {took.ElapsedMilliseconds} ms");
            Equal(ClientState.Disposed, client.State);
        }

        // Nobody answers: the fifth of four is refused, at once, and each of the four ends once, on this thread.
        private static void Refusal(string endpoint)
        {
            var ended = new List<int>();
            var thread = Environment.CurrentManagedThreadId;
            var client = new BackgroundClient(endpoint, TimeSpan.FromSeconds(10), capacity: 4);
            for (var i = 1; i <= 4; i++)
            {
                var number = i;
                Check(client.Request("hello", _ => Check(false, "a reply"), why =>
                {
                    Equal("the client was disposed", why);
                    Equal(thread, Environment.CurrentManagedThreadId);
                    Check(!client.Request("hello", null), "accepted while it is disposed");
                    ended.Add(number);
                }), "refused too early");
            }
            Check(!client.Request("hello", _ => Check(false, "a reply"), _ => Check(false, "an error")), "not refused");
            var refused = client.RequestAsync("hello");
            Check(refused.Exception?.InnerException is IOException, "RequestAsync of a full client");
            client.Poll();
            Equal(0, ended.Count);
            StopInTime(client);
            Equal("1 2 3 4", string.Join(" ", ended));
            client.Poll();
            client.Dispose();
            Check(!client.Request("hello", null), "accepted after Dispose");
            Equal(4, ended.Count);
        }

        // Stop at every moment, twenty times, without a pause: the next client must not find a context that ends.
        private static void Stop(string endpoint)
        {
            for (var round = 0; round < 20; round++)
            {
                var ends = 0;
                var client = new BackgroundClient(endpoint, TimeSpan.FromSeconds(10));
                for (var i = 0; i < round; i++) client.Request("hello", _ => ends++, _ => ends++);
                Thread.Sleep(5 * round);
                StopInTime(client);
                Equal(round, ends);
            }
        }

        // What was answered, but not polled yet, is still a reply when the client is disposed.
        private static void StopAnswered(string endpoint)
        {
            string got = null;
            var client = new BackgroundClient(endpoint);
            client.Request("hello", reply => got = reply, why => got = why);
            Until(() => client.Replies == 1);
            StopInTime(client);
            Equal("world", got);
        }

        private static void OneAfterAnother(string endpoint)
        {
            // What never ends is given up. Those of one Stop share 200 ms; were each waited for so long, it would be 10 s.
            var stuck = Enumerable.Range(0, 50).Select(_ => new Thread(() => Thread.Sleep(60000)) { IsBackground = true }).ToArray();
            foreach (var thread in stuck) thread.Start();
            var watch = Stopwatch.StartNew();
            foreach (var thread in stuck) NetworkThread.Join(thread);
            Check(watch.Elapsed < TimeSpan.FromSeconds(8), $"fifty waits took {watch.Elapsed}");
            // A game that changes its server now and then: a wait that comes a second later has its own time.
            Thread.Sleep(1100);
            watch.Restart();
            NetworkThread.Join(stuck[0]);
            Check(watch.ElapsedMilliseconds > 100, $"the next Stop waited for {watch.ElapsedMilliseconds} ms only");
        }

        private static void Why(string endpoint)
        {
            Equal("no reply", LogText.Why(new TimeoutException("no reply")));
            Equal("bad-json: the header", LogText.Why(new MessageException("bad-json", "the header")));
            // What IL2CPP says when something was stripped away.
            var unforeseen = LogText.Why(new TypeInitializationException("Boom", new NotSupportedException("not in this build")));
            Check(unforeseen.Contains("NotSupportedException") && unforeseen.Contains("not in this build"), unforeseen);
        }

        // A name that is looked up in vain: the reason reaches the caller, and the thread goes on.
        private static void LookUp(string endpoint)
        {
            using var client = new BackgroundClient(endpoint);
            for (var i = 0; i < 2; i++)
            {
                string why = null;
                client.Request("hello", null, error => why = error);
                Until(() => why != null, client);
                Console.WriteLine(why);
                Check(why.StartsWith($"bad endpoint '{endpoint}'", StringComparison.Ordinal), why);
                Equal(why, client.LastError);
                Equal(ClientState.Lost, client.State);
            }
        }

        // The network thread hangs in a call that nobody can interrupt. Here it waits to join NetMQ's users; it could as
        // well look up the name of a host.
        private static void Stuck(string endpoint)
        {
            const BindingFlags hidden = BindingFlags.Static | BindingFlags.NonPublic;
            var gate = typeof(NetMQLifetime).GetField("Gate", hidden).GetValue(null);
            var ends = new List<string>();
            var client = new BackgroundClient(endpoint);
            lock (gate)
            {
                for (var i = 0; i < 3; i++) client.Request("hello", ends.Add, ends.Add);
                Thread.Sleep(100);
                StopInTime(client);
                Equal(3, ends.Count);
            }
            Thread.Sleep(300);
            client.Poll();
            Equal("the client was disposed", string.Join("", ends.Distinct()));
            Equal(3, ends.Count);
        }

        // Somebody else's socket was never disposed, and NetMQ's end waits for it. Nothing on this thread does.
        private static void Forgotten(string endpoint)
        {
            var forgotten = new RequestSocket();
            string got = null;
            using (var client = new BackgroundClient(endpoint))
            {
                client.Request("hello", reply => got = reply, why => got = why);
                Until(() => got != null, client);
                Equal("world", got);
                // NetMQ's end is waited for by whoever comes next, 10 s.
                StopInTime(client, 1500);
            }
            Thread.Sleep(300);
            var next = new BackgroundClient(endpoint);
            got = null;
            next.Request("hello", reply => got = reply, why => got = why);
            Until(() => got != null, next);
            Console.WriteLine(got);
            Check(got.StartsWith("NetMQ has not ended for ", StringComparison.Ordinal), got);
            forgotten.Dispose();
            for (var waited = Stopwatch.StartNew(); got != "world"; Thread.Sleep(10))
            {
                // As long as NetMQ has not ended, each request fails at once.
                Check(waited.Elapsed < TimeSpan.FromSeconds(30), $"did not recover: {got}");
                got = null;
                next.Request("hello", reply => got = reply, why => got = why);
                Until(() => got != null, next);
            }
            StopInTime(next);
        }

        // Five clients at once, each with its own replies; one leaves early and takes nobody with it.
        private static void Many(string endpoint)
        {
            const int count = 200;
            var clients = Enumerable.Range(0, 5).Select(_ => new BackgroundClient(endpoint, TimeSpan.FromSeconds(20))).ToArray();
            var got = clients.Select(_ => new List<string>()).ToArray();
            for (var i = 0; i < count; i++)
                for (var c = 0; c < clients.Length; c++)
                {
                    var mine = got[c];
                    Until(() => clients[c].Request($"echo {c}-{i}", mine.Add, why => mine.Add($"! {why}")) || clients[c].State == ClientState.Disposed, clients);
                    if (c == 2 && i == count / 2) StopInTime(clients[c]);
                }
            Until(() => clients.Where((_, c) => c != 2).All(client => client.Replies == count) && got[4].Count == count, clients);
            foreach (var client in clients) client.Dispose();
            for (var c = 0; c < clients.Length; c++)
            {
                if (c == 2) continue;
                Equal(string.Join(" ", Enumerable.Range(0, count).Select(i => $"{c}-{i}")), string.Join(" ", got[c]));
            }
            Equal(count / 2 + 1, got[2].Count);
        }

        private static void Await(string endpoint)
        {
            var thread = Environment.CurrentManagedThreadId;
            var client = new BackgroundClient(endpoint);
            async Task<string> Talk()
            {
                var all = "";
                for (var i = 0; i < 5; i++)
                {
                    all += await client.RequestAsync($"echo {i}");
                    Equal(thread, Environment.CurrentManagedThreadId);
                }
                return all;
            }
            var talk = Talk();
            Until(() => talk.IsCompleted, client);
            Equal("01234", talk.Result);

            async Task<string> Interrupted()
            {
                try
                {
                    return await client.RequestAsync("hello");
                }
                catch (IOException e)
                {
                    Equal(thread, Environment.CurrentManagedThreadId);
                    return e.Message;
                }
            }
            var interrupted = Interrupted();
            client.Dispose();
            Check(interrupted.IsCompleted, "Dispose left an await waiting");
            Console.WriteLine(interrupted.Result);
        }

        // An exception of a callback comes out of Poll, and keeps no other callback from running: not in Poll, not in Dispose.
        private static void Throwing(string endpoint)
        {
            int thrown = 0, ran = 0;
            var client = new BackgroundClient(endpoint, TimeSpan.FromSeconds(20));
            void Throw(string text)
            {
                ran++;
                throw new FormatException(text);
            }
            for (var i = 0; i < 10; i++) client.Request("hello", Throw, Throw);
            Until(() =>
            {
                try
                {
                    client.Poll();
                }
                catch (FormatException)
                {
                    thrown++;
                }
                return thrown == 10;
            });
            Equal(10, ran);
            for (var i = 0; i < 10; i++) client.Request("hello", Throw, Throw);
            try
            {
                client.Dispose();
                Check(false, "Dispose kept the exception for itself");
            }
            catch (FormatException)
            {
                Equal(20, ran);
            }
        }

        // Callbacks that ask, poll and dispose.
        private static void Nested(string endpoint)
        {
            var (asked, replies, errors) = (0, 0, 0);
            var client = new BackgroundClient(endpoint);
            void Ask()
            {
                if (client.Request("hello", Again, _ => errors++)) asked++;
            }
            void Again(string reply)
            {
                Equal("world", reply);
                replies++;
                client.Poll();
                if (replies >= 100) client.Dispose();
                Ask();
            }
            for (var i = 0; i < 10; i++) Ask();
            Until(() => client.State == ClientState.Disposed, client);
            Check(replies >= 100 && replies + errors == asked, $"{asked} requests, {replies} replies, {errors} errors");
            Console.WriteLine($"{replies} replies, {errors} errors");
        }

        // Somebody else's code ends NetMQ for the whole process, as many examples do in OnDestroy.
        private static void Cleanup(string endpoint)
        {
            using var client = new BackgroundClient(endpoint, TimeSpan.FromSeconds(0.5));
            for (var round = 0; round < 5; round++)
            {
                string got = null;
                client.Request("hello", reply => got = reply, why => got = why);
                if (round % 2 == 0) Until(() => got != null, client);
                NetMQConfig.Cleanup(false);
                Until(() => got != null, client);
                Console.WriteLine(got);
            }
            string last = null;
            for (var tries = 0; last != "world"; tries++)
            {
                Check(tries < 5, $"did not recover: {last}");
                last = null;
                client.Request("hello", reply => last = reply, why => last = why);
                Until(() => last != null, client);
            }
        }

        // What a head-up display shows; the test's server answers the second request once it was seen that it is sent again.
        private static void State(string endpoint)
        {
            var client = new BackgroundClient(endpoint, TimeSpan.FromSeconds(4));
            Equal((ClientState.Connecting, "", 0, TimeSpan.Zero), (client.State, client.LastError, client.Replies, client.RoundTripTime));
            var (asked, ended, seen) = (0, 0, "");
            void See(string _)
            {
                if (++ended > 4) return;
                Equal(ClientState.Connected, client.State);
                Check(client.RoundTripTime > TimeSpan.Zero && client.RoundTripTime < Limit, $"round trip {client.RoundTripTime}");
            }
            Until(() =>
            {
                // Before the next request, which changes it.
                var (state, error) = client.Status;
                if (seen != $"{state} {error}") Console.WriteLine(seen = $"{state} {error}");
                if (asked == ended && ended < 4 && client.Request("hello", See, why => Check(ended >= 4, why))) asked++;
                return ended == 4;
            }, client);
            Equal(4, client.Replies);
            client.Dispose();
        }

        // Whoever reads State and LastError together gets those of one moment. Both speak of the same try here.
        private static void Pairs(string endpoint)
        {
            using var client = new BackgroundClient(endpoint, TimeSpan.FromMilliseconds(1), tries: 2);
            var (done, wrong, reads) = (false, "", 0);
            var reader = new Thread(() =>
            {
                for (; !Volatile.Read(ref done); reads++)
                {
                    var (state, error) = client.Status;
                    var expected = state == ClientState.Retrying ? "try 2 of 2" : state == ClientState.Lost ? "may have been done or not" : "";
                    if (!error.EndsWith(expected, StringComparison.Ordinal)) wrong = $"{state} {error}";
                }
            });
            reader.Start();
            var ends = 0;
            for (var i = 0; i < 60; i++)
            {
                client.Request("hello", null, _ => ends++);
                Until(() => ends > i, client);
            }
            Volatile.Write(ref done, true);
            Check(reader.Join(Limit), "the reader does not end");
            Equal("", wrong);
            Console.WriteLine($"{reads} times");
        }

        // More than a server takes in one frame: said, and not sent.
        private static void TooLong(string endpoint)
        {
            using var client = new BackgroundClient(endpoint);
            string got = null;
            try
            {
                client.Request(new string('ü', 40000), null);
                Check(false, "a text of 80,000 bytes was taken");
            }
            catch (ArgumentException e)
            {
                Equal("more than 65536 bytes", e.Message);
            }
            client.Request("echo " + new string('ü', 20000), text => got = text, why => got = why);
            Until(() => got != null, client);
            Equal(new string('ü', 20000), got);
        }

        // There are too many sockets to make another: who fails so is no user of NetMQ, and does not keep it from its end.
        private static void NoSocket(string endpoint)
        {
            NetMQConfig.MaxSockets = 1;
            using (new NetMQLifetime())
            using (new RequestSocket())
            {
                foreach (var make in new Func<IDisposable>[]
                {
                    () => new HelloRequester(endpoint),
                    () => new LazyPirateRequester(endpoint, Limit, 1, _ => { }),
                    () => new TopicListener(endpoint, ""),
                    () => new PoseSubscriber(endpoint, null, _ => { }),
                })
                {
                    try
                    {
                        make().Dispose();
                        Check(false, "made in spite of the limit");
                    }
                    catch (NetMQException e)
                    {
                        Console.WriteLine(e.Message);
                    }
                }
            }
            // The last user has ended NetMQ, so that a new limit holds.
            NetMQConfig.MaxSockets = 2;
            using var lifetime = new NetMQLifetime();
            using var first = new RequestSocket();
            using var second = new RequestSocket();
        }

        // Nothing comes, and the wait ends when it is told to.
        private static void ListenerStops(string endpoint)
        {
            using var listener = new TopicListener(endpoint, "");
            using var stop = new CancellationTokenSource();
            var cancelled = new Stopwatch();
            new Thread(() =>
            {
                Thread.Sleep(200);
                cancelled.Start();
                stop.Cancel();
            }).Start();
            try
            {
                listener.Receive(TimeSpan.FromSeconds(20), stop.Token);
                Check(false, "received something");
            }
            catch (OperationCanceledException)
            {
                Console.WriteLine($"stopped in {cancelled.ElapsedMilliseconds} ms");
                Check(cancelled.ElapsedMilliseconds < 10_000, "too late");
            }
        }

        // Neither an idle client nor one that waits for a reply may use the processor.
        private static void Asleep(string endpoint)
        {
            using var client = new BackgroundClient(endpoint, TimeSpan.FromSeconds(10));
            foreach (var what in new[] { "idle", "waiting" })
            {
                if (what == "waiting") client.Request("hello", null);
                Thread.Sleep(200);
                var before = Process.GetCurrentProcess().TotalProcessorTime;
                Thread.Sleep(2000);
                var used = Process.GetCurrentProcess().TotalProcessorTime - before;
                Console.WriteLine($"{what}: {used.TotalMilliseconds:F0} ms of processor time in 2000 ms");
                Check(used.TotalMilliseconds < 400, "it does not sleep");
            }
        }

        // A client whose owner forgets to call Poll holds 64 replies and not more.
        private static void NeverPolled(string endpoint)
        {
            using var client = new BackgroundClient(endpoint);
            var accepted = 0;
            var replies = 0;
            for (; client.Request("hello", _ => replies++); accepted++) { }
            Equal(64, accepted);
            Until(() => client.Replies == 64);
            Check(!client.Request("hello", null), "replies that nobody polled do not count");
            client.Poll();
            Equal(64, replies);
            Check(client.Request("hello", _ => replies++), "no room after Poll");
            Until(() => replies == 65, client);
        }

        // What a frame does, with callbacks that are made once, leaves the garbage collector nothing to do.
        private static void AllocatesNothing(string endpoint)
        {
            using var client = new BackgroundClient(endpoint);
            var (replies, why) = (0, (string)null);
            Action<string> onReply = _ => replies++, onError = error => why = error;
            var before = 0L;
            // A busy machine may have answered none of them by then.
            for (var frame = 0; frame < 400 || (replies == 0 && why == null); frame++)
            {
                // The first frames compile code and let the queues grow.
                if (frame == 100) before = GC.GetAllocatedBytesForCurrentThread();
                client.Poll();
                client.Request("hello", onReply, onError);
                Thread.Sleep(1);
            }
            Equal(0L, GC.GetAllocatedBytesForCurrentThread() - before);
            Check(replies > 0 && why == null, $"{replies} replies, {why}");
            Console.WriteLine($"{replies} replies");
        }

        // While the test kills and restarts the server: every request ends once, and a reply is that of its request.
        private static void Randomly(string endpoint)
        {
            var random = new Random(4);
            for (var round = 0; round < 15; round++)
            {
                var ends = new List<int>();
                var client = new BackgroundClient(endpoint, TimeSpan.FromSeconds(0.1 + random.NextDouble() / 5), tries: 1 + random.Next(4));
                var right = true;
                var frames = random.Next(20, 400);
                for (var frame = 0; frame < frames; frame++)
                {
                    client.Poll();
                    var text = $"{round}-{ends.Count}";
                    var at = ends.Count;
                    if (client.Request($"echo {text}", reply => { ends[at]++; right &= reply == text; }, _ => ends[at]++)) ends.Add(0);
                    Thread.Sleep(random.Next(3));
                }
                StopInTime(client);
                Check(right, "a reply to another request");
                Check(ends.All(times => times == 1), "ended " + string.Join(" ", ends));
                Console.WriteLine($"round {round}: {ends.Count} requests, {client.Replies} replies");
            }
        }
    }
}
