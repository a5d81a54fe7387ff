// Checks of BackgroundClient, one after the other: dotnet checks.dll background CHECK=ENDPOINT … The test has the
// servers.
//
// Prints what happened, and "CHECK: ok" after each; ends with 1 and "failed: …" at the first thing that is wrong.
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
using Random = System.Random;

namespace NetMQExample.Tests
{
    internal static class BackgroundClientChecks
    {
        private static readonly TimeSpan Limit = TimeSpan.FromSeconds(60);

        public static int Run(string[] words)
        {
            var checks = new Action<string>[]
            {
                AllocatesNothing, Ask, Asleep, Await, Cancelled, Cleanup, ListenerStops, LookUp, Nested, NeverPolled,
                NoSocket, OneAfterAnother, Randomly, Refusal, State, Stuck, Throwing, Why, Within,
            }.ToDictionary(check => check.Method.Name);
            try
            {
                foreach (var word in words.Select(word => word.Split('=')))
                {
                    checks[word[0]](word[1]);
                    Console.WriteLine($"{word[0]}: ok");
                }
                return 0;
            }
            catch (Exception e)
            {
                Console.WriteLine($"failed: {e}");
                return 1;
            }
        }

        internal static void Check(bool right, string what)
        {
            if (!right) throw new InvalidOperationException(what);
        }

        private static void Equal<T>(T expected, T actual) =>
            Check(Equals(expected, actual), $"expected {expected}, got {actual}");

        internal static T Throws<T>(Action act) where T : Exception
        {
            try { act(); }
            catch (T e) { return e; }
            throw new InvalidOperationException($"there was no {typeof(T).Name}");
        }

        // Frames until something is true.
        private static void Until(Func<bool> condition, params BackgroundClient[] clients)
        {
            for (var waited = Stopwatch.StartNew(); !condition(); Thread.Sleep(1))
            {
                Check(waited.Elapsed < Limit,
                    "took too long: " + string.Join("; ", clients.Select(c => $"{c.State} {c.LastError}")));
                foreach (var client in clients) client.Poll();
            }
        }

        // The reply to a request, or why there is none.
        private static string Answer(BackgroundClient client, string text = "hello")
        {
            string got = null;
            client.Request(text, reply => got = reply, why => got = why);
            Until(() => got != null, client);
            return got;
        }

        // It waits 200 ms at the most, and later only where a busy machine has no core for it. Where nobody
        // answers the timeout is longer than this limit, which so tells a Dispose that waits for it from one that does
        // not.
        private static void StopInTime(BackgroundClient client)
        {
            var took = Stopwatch.StartNew();
            client.Dispose();
            Check(took.ElapsedMilliseconds < 5000, $"Dispose took {took.ElapsedMilliseconds} ms");
            Console.WriteLine($"stopped in {took.ElapsedMilliseconds} ms");
            Equal(ClientState.Disposed, client.State);
        }

        // A request that is cancelled before it is sent leaves room for another. Later it ends the wait alone.
        private static void Cancelled(string endpoint)
        {
            using var client = new BackgroundClient(endpoint, TimeSpan.FromSeconds(10), capacity: 1);
            Check(client.RequestAsync("hello", new CancellationToken(true)).IsCanceled, "not cancelled before");
            using var cancel = new CancellationTokenSource();
            var waits = client.RequestAsync("hello", cancel.Token);
            Check(!waits.IsCompleted, "no room after a request that was cancelled before it was sent");
            cancel.Cancel();
            Check(waits.IsCanceled, "not cancelled");
            Check(client.RequestAsync("hello").Exception?.InnerException is GaveUpException,
                "the request is under way no more");
            using var asking = new BackgroundClient(endpoint);
            using var destroyed = new CancellationTokenSource();
            var asked = asking.AskAsync<Wish, Order>(new Wish(), destroyed.Token);
            destroyed.Cancel();
            Check(asked.IsCanceled, "an object is waited for");
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
            Check(refused.Exception?.InnerException is GaveUpException, "RequestAsync of a full client");
            client.Poll();
            Equal(0, ended.Count);
            StopInTime(client);
            Equal("1 2 3 4", string.Join(" ", ended));
            client.Poll();
            client.Dispose();
            Check(!client.Request("hello", null), "accepted after Dispose");
            Equal(4, ended.Count);
        }

        // A game changes its server now and then: a wait that comes a second after the last one has its own time.
        private static void OneAfterAnother(string endpoint)
        {
            var stuck = new Thread(() => Thread.Sleep(60000)) { IsBackground = true };
            stuck.Start();
            NetworkThread.Join(stuck);
            Thread.Sleep(1100);
            var watch = Stopwatch.StartNew();
            NetworkThread.Join(stuck);
            Check(watch.ElapsedMilliseconds > 100, $"the next Stop waited for {watch.ElapsedMilliseconds} ms only");
        }

        // Nobody answers: all tries together take no longer than this, and a try that waits longer is cut.
        private static void Within(string endpoint)
        {
            using var pirate = new LazyPirateRequester(endpoint, TimeSpan.FromSeconds(0.2), tries: 100);
            foreach (var within in new[] { 0.1, 1.5 })
                Console.WriteLine(Throws<TimeoutException>(
                    () => pirate.Request("hello", within: TimeSpan.FromSeconds(within))).Message);
            Throws<ArgumentException>(() => pirate.Request("hello", within: TimeSpan.Zero));
        }

        private static void Why(string endpoint)
        {
            Equal("no reply", LogText.Why(new TimeoutException("no reply")));
            Equal("bad-json: the header", LogText.Why(new MessageException("bad-json", "the header")));
            // IL2CPP says this when something was stripped away.
            var unforeseen =
                LogText.Why(new TypeInitializationException("Boom", new NotSupportedException("not in this build")));
            Check(unforeseen.Contains("NotSupportedException") && unforeseen.Contains("not in this build"), unforeseen);
        }

        // A name that is looked up in vain: the reason reaches the caller, and the thread goes on.
        private static void LookUp(string endpoint)
        {
            using var client = new BackgroundClient(endpoint);
            for (var i = 0; i < 2; i++)
            {
                var why = Answer(client);
                Console.WriteLine(why);
                Check(why.StartsWith($"bad endpoint '{endpoint}'", StringComparison.Ordinal), why);
                Equal(why, client.LastError);
                Equal(ClientState.Lost, client.State);
            }
        }

        // The network thread hangs in a call that nobody can interrupt. Here it waits to join NetMQ's users; it could
        // as well look up the name of a host.
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

            // Where nobody listens.
            var unanswered = new BackgroundClient("tcp://127.0.0.1:1");
            var interrupted = unanswered.RequestAsync("hello");
            unanswered.Dispose();
            Check(interrupted.IsCompleted, "Dispose left an await waiting");
            Equal("the client was disposed",
                Throws<ObjectDisposedException>(() => interrupted.GetAwaiter().GetResult()).Message);
            Throws<ObjectDisposedException>(() => unanswered.RequestAsync("hello").GetAwaiter().GetResult());
            using var hasty = new BackgroundClient("tcp://127.0.0.1:1", TimeSpan.FromMilliseconds(1), tries: 1);
            var late = hasty.RequestAsync("hello");
            Until(() => late.IsCompleted, hasty);
            Throws<TimeoutException>(() => late.GetAwaiter().GetResult());
            client.Dispose();
        }

        public sealed class Wish
        {
            public string reply;
            public UnityEngine.Vector3 place;
            public UnityEngine.Vector3? none = null;
            public DayOfWeek day = DayOfWeek.Friday;
            [NonSerialized] public int secret;
        }

        public sealed class Order
        {
            public string say = "nothing";
            public int times = 7;
            public List<UnityEngine.Vector3> way = null;
            public DayOfWeek day = DayOfWeek.Monday;
            public float Speed { get; set; }
        }

        // The server replies with what it is told to. `the state` is a request for the state itself.
        private static void Ask(string endpoint)
        {
            // A game's own rules, which let who writes the JSON choose the class.
            Newtonsoft.Json.JsonConvert.DefaultSettings = () => new Newtonsoft.Json.JsonSerializerSettings
            {
                TypeNameHandling = Newtonsoft.Json.TypeNameHandling.All,
            };
            using var client = new BackgroundClient(endpoint, TimeSpan.FromSeconds(20));
            string Show(Order order)
            {
                var way = order.way == null ? "-" : string.Join(" ", order.way);
                return FormattableString.Invariant($"{order.say} {order.times} {order.Speed} {order.day:D} {way}");
            }
            foreach (var (reply, wanted) in new[]
            {
                (@"{""say"":""hi"",""times"":2,""Speed"":0.5,""way"":[{""x"":1,""y"":-2,""z"":0.5}]}",
                    "hi 2 0.5 1 (1.00, -2.00, 0.50)"),
                (@"{""SAY"":""grün ✓""}", "grün ✓ 7 0 1 -"),
                ("{}", "nothing 7 0 1 -"),
                ("error: no 'guest'", "! error: no 'guest'"),
                (@"{""sya"":1}",
                    "! the reply {\"sya\":1} does not fit Order: Could not find member 'sya' on object of type "
                    + "'Order'. Path 'sya', line 1, position 7."),
                (@"{""way"":[{""w"":1}]}",
                    "! the reply {\"way\":[{\"w\":1}]} does not fit Order: Could not find member 'w' on object of type "
                    + "'Vector3'. Path 'way[0].w', line 1, position 13."),
                (@"{""Speed"":NaN}", "! the reply {\"Speed\":NaN} does not fit Order: NaN is not JSON. Path 'Speed'."),
                (@"{""day"":""Sunday""}", "nothing 7 0 0 -"),
                ("null", "! the reply null does not fit Order: It is no object."),
                ("", "! the reply  does not fit Order: It is no object."),
                ("wo\nrld",
                    "! the reply wo?rld does not fit Order: Unexpected character encountered while parsing value: w. "
                    + "Path '', line 0, position 0."),
                (@"{""$type"":""System.IO.FileInfo"",""say"":""x""}", "x 7 0 1 -"),
            })
            {
                var (got, wish) = ("", new Wish { reply = reply });
                Check(client.Ask<Wish, Order>(wish, order => got += Show(order), why => got += $"! {why}"), "refused");
                Until(() => got != "", client);
                Equal(wanted, got);
                var task = client.AskAsync<Wish, Order>(wish);
                Until(() => task.IsCompleted, client);
                Equal(wanted,
                    task.IsFaulted
                        ? $"! {((GaveUpException)task.Exception.InnerException).Message}"
                        : Show(task.Result));
            }
            var state = new Wish { reply = "the state", place = new UnityEngine.Vector3(1, 2.5f, -3), secret = 1 };
            string sent = null;
            Check(client.Ask<Wish, Order>(state, order => sent = order.say, why => sent = why), "refused");
            Until(() => sent != null, client);
            Equal(@"{""reply"":""the state"",""place"":{""x"":1.0,""y"":2.5,""z"":-3.0},""none"":null,"
                + @"""day"":""Friday""}", sent);
            foreach (var wrong in new object[] { float.NaN, 1 / 0.0, new { x = -1 / 0f }, new[] { double.NaN },
                new float?[] { null, float.NaN } })
            {
                Throws<Newtonsoft.Json.JsonException>(() => client.Ask<object, Order>(wrong, null, null));
                var task = client.AskAsync<object, Order>(wrong);
                Throws<Newtonsoft.Json.JsonException>(() => task.GetAwaiter().GetResult());
            }
        }

        // An exception of a callback comes out of Poll, and keeps no other callback from running: not in Poll, not in
        // Dispose.
        private static void Throwing(string endpoint)
        {
            int thrown = 0, ran = 0;
            var client = new BackgroundClient(endpoint, TimeSpan.FromSeconds(20));
            void Throw(string text)
            {
                ran++;
                throw new FormatException(text);
            }
            for (var i = 0; i < 5; i++) client.Request("hello", Throw, Throw);
            Until(() =>
            {
                try { client.Poll(); }
                catch (FormatException) { thrown++; }
                return thrown == 5;
            });
            Equal(5, ran);
            for (var i = 0; i < 5; i++) client.Request("hello", Throw, Throw);
            Throws<FormatException>(client.Dispose);
            Equal(10, ran);
            // More than a stack has room for.
            var many = new BackgroundClient(endpoint, capacity: 20_000);
            while (many.Request("hello", Throw, Throw)) { }
            Throws<FormatException>(many.Dispose);
            Equal(20_010, ran);
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
                if (replies >= 20) client.Dispose();
                Ask();
            }
            for (var i = 0; i < 10; i++) Ask();
            Until(() => client.State == ClientState.Disposed, client);
            Check(replies >= 20 && replies + errors == asked, $"{asked} requests, {replies} replies, {errors} errors");
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
            var last = "";
            for (var tries = 0; last != "world"; tries++)
            {
                Check(tries < 5, $"did not recover: {last}");
                last = Answer(client);
            }
        }

        // A head-up display shows this; the test's server answers the second request once it was seen that it is sent
        // again.
        private static void State(string endpoint)
        {
            var client = new BackgroundClient(endpoint, TimeSpan.FromSeconds(4));
            Equal((ClientState.Connecting, "", 0, TimeSpan.Zero),
                (client.State, client.LastError, client.Replies, client.RoundTripTime));
            var (asked, ended, seen) = (0, 0, "");
            void See(string _)
            {
                if (++ended > 4) return;
                Equal(ClientState.Connected, client.State);
                Equal("", client.LastError);
                Check(client.RoundTripTime > TimeSpan.Zero && client.RoundTripTime < Limit,
                    $"round trip {client.RoundTripTime}");
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

        // There are too many sockets to make another: who fails so is no user of NetMQ, and does not keep it from its
        // end.
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
                    Console.WriteLine(Throws<NetMQException>(() => make().Dispose()).Message);
            }
            // The last user has ended NetMQ, so that a new limit holds.
            NetMQConfig.MaxSockets = 2;
            using (new NetMQLifetime())
            using (new RequestSocket())
            using (new RequestSocket()) { }
            NetMQConfig.MaxSockets = 1024;
        }

        // Nothing comes, and the wait ends when it is told to: with a timeout of its own the exception would be
        // another.
        private static void ListenerStops(string endpoint)
        {
            using var listener = new TopicListener(endpoint, "");
            using var stop = new CancellationTokenSource(200);
            Throws<OperationCanceledException>(() => listener.Receive(TimeSpan.FromSeconds(20), stop.Token));
        }

        // Neither an idle client nor one that waits for a reply may use the processor.
        private static void Asleep(string endpoint)
        {
            using var client = new BackgroundClient(endpoint, TimeSpan.FromSeconds(10));
            foreach (var what in new[] { "idle", "waiting" })
            {
                if (what == "waiting") client.Request("hello", null);
                // .NET may still compile once more what ran before in this process; a client that never sleeps has no
                // such time.
                TimeSpan used;
                var left = 20;
                do
                {
                    var before = Process.GetCurrentProcess().TotalProcessorTime;
                    Thread.Sleep(500);
                    used = Process.GetCurrentProcess().TotalProcessorTime - before;
                }
                while (used.TotalMilliseconds >= 100 && --left > 0);
                Console.WriteLine($"{what}: {used.TotalMilliseconds:F0} ms of processor time in 500 ms");
                Check(left > 0, "it does not sleep");
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

        // A frame leaves the garbage collector nothing to do, if its callbacks are made once.
        private static void AllocatesNothing(string endpoint)
        {
            using var client = new BackgroundClient(endpoint);
            var (replies, why) = (0, (string)null);
            Action<string> onReply = _ => replies++, onError = error => why = error;
            var before = 0L;
            // A busy machine may have answered none of them by then.
            for (var frame = 0; frame < 200 || (replies == 0 && why == null); frame++)
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
            for (var round = 0; round < 5; round++)
            {
                var ends = new List<int>();
                var client = new BackgroundClient(endpoint, TimeSpan.FromSeconds(0.1 + random.NextDouble() / 5),
                    tries: 1 + random.Next(4));
                var right = true;
                var frames = random.Next(20, 300);
                for (var frame = 0; frame < frames; frame++)
                {
                    client.Poll();
                    var text = $"{round}-{ends.Count}";
                    var at = ends.Count;
                    if (client.Request($"echo {text}", reply => { ends[at]++; right &= reply == text; },
                        _ => ends[at]++))
                        ends.Add(0);
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
