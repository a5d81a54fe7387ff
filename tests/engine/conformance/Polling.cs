// Waiting for several things: Poll, NetMQPoller with sockets, timers, queues and tasks.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample.Conformance
{
    internal static class Polling
    {
        internal static void Run()
        {
            OneSocket();
            SeveralSockets();
            Timers();
            Queues();
            Tasks();
            Stopping();
            Removing();
        }

        private static void OneSocket()
        {
            PairSocket.CreateSocketPair(out var one, out var two);
            using (one)
            using (two)
            {
                Say.That("ready", one.HasIn, one.HasOut);
                Say.That("poll in", one.Poll(PollEvents.PollIn, TimeSpan.Zero));
                Say.That("poll in or out", one.Poll(PollEvents.PollIn | PollEvents.PollOut, Say.Timeout));
                var clock = Stopwatch.StartNew();
                Say.That("without events", one.Poll(TimeSpan.FromMilliseconds(100)));
                Say.That("waited", clock.ElapsedMilliseconds >= 95);
                var heard = new List<string>();
                one.ReceiveReady += (_, e)
                    => heard.Add($"{e.IsReadyToReceive} {e.IsReadyToSend} {e.Socket.ReceiveFrameString()}");
                Say.That("nothing to receive", one.Poll(TimeSpan.FromMilliseconds(20)));
                two.SendFrame("x");
                Say.That("received", one.Poll(Say.Timeout));
                two.SendFrame("y");
                one.Poll();
                EventHandler<NetMQSocketEventArgs> sendReady = (_, e)
                    => heard.Add($"{e.IsReadyToReceive} {e.IsReadyToSend}");
                one.SendReady += sendReady;
                Say.That("can send", one.Poll(Say.Timeout));
                one.SendReady -= sendReady;
                Say.That("events", heard);
            }
            using var server = new ResponseSocket("@inproc://poll");
            using var client = new RequestSocket(">inproc://poll");
            Say.That("REQ at first", client.HasIn, client.HasOut);
            Say.That("REP at first", server.HasIn, server.HasOut);
            client.SendFrame("x");
            Say.That("REQ waits", client.HasIn, client.HasOut);
            Say.That("REP has a request", Say.Soon(() => server.HasIn) && !server.HasOut);
            server.SkipFrame();
            Say.That("REP owes a reply", server.HasIn, server.HasOut);
        }

        private static void SeveralSockets()
        {
            using var server = new ResponseSocket("@tcp://127.0.0.1:0");
            using var pull = new PullSocket("@inproc://poller-pull");
            using var client = new RequestSocket(server.Options.LastEndpoint);
            using var push = new PushSocket(">inproc://poller-pull");
            using var poller = new NetMQPoller { server, pull };
            var pulled = new List<string>();
            var senders = new List<object?>();
            server.ReceiveReady += (sender, e) =>
            {
                senders.Add(sender);
                e.Socket.SendFrame(e.Socket.ReceiveFrameString() + "!");
            };
            pull.ReceiveReady += (_, e) =>
            {
                lock (pulled) pulled.Add(e.Socket.ReceiveFrameString());
            };
            Say.That("running", poller.IsRunning);
            poller.RunAsync();
            Say.That("running", poller.IsRunning);
            Say.ThrowsText("run twice", () => poller.RunAsync());
            for (var i = 0; i < 3; i++)
            {
                push.SendFrame($"{i}");
                client.SendFrame($"{i}");
                Say.That("reply", Say.Received(client));
            }
            Say.That("pulled", Say.Soon(() => { lock (pulled) return pulled.Count == 3; }) ? string.Join(",", pulled)
                : "too few");
            Say.That("the sender is the poller", senders.All(s => s == poller));
            poller.Stop();
            Say.That("running", poller.IsRunning);
        }

        private static void Timers()
        {
            var timer = new NetMQTimer(TimeSpan.FromMilliseconds(20));
            var other = new NetMQTimer(60_000) { Enable = false };
            Say.That("timer", timer.Interval, timer.Enable, other.Interval, other.Enable);
            var clock = Stopwatch.StartNew();
            using var poller = new NetMQPoller { timer, other };
            var ticks = 0;
            var otherTicks = 0;
            timer.Elapsed += (_, e) =>
            {
                if (++ticks == 3) e.Timer.Enable = false;
                if (ticks != 3) return;
                other.Interval = 10;
                other.Enable = true;
            };
            other.Elapsed += (sender, e) =>
            {
                otherTicks++;
                e.Timer.Enable = false;
                ((NetMQPoller)sender!).Stop();
            };
            poller.Run();
            Say.That("ticks", ticks, otherTicks);
            Say.That("not too early", clock.ElapsedMilliseconds >= 65);
            timer.EnableAndReset();
            Say.That("enabled again", timer.Enable);
            poller.Remove(timer);
        }

        private static void Queues()
        {
            using var queue = new NetMQQueue<int>();
            Say.That("empty queue", queue.Count, queue.IsEmpty, queue.TryDequeue(out _, TimeSpan.Zero));
            queue.Enqueue(1);
            queue.Enqueue(2);
            Say.That("two items", queue.Count, string.Join(",", queue));
            Say.That("dequeued", queue.Dequeue(), queue.TryDequeue(out var item, Say.Timeout), item, queue.IsEmpty);

            using (var small = new NetMQQueue<int>(4))
            {
                var writer = new Thread(() =>
                {
                    for (var i = 0; i < 10; i++) small.Enqueue(i);
                });
                writer.IsBackground = true;
                writer.Start();
                Say.That("a full queue holds the writer up", Say.Soon(() => small.Count >= 5)
                    && !writer.Join(Say.Moment) && small.Count == 5);
                var got = new List<int>();
                while (got.Count < 10 && small.TryDequeue(out item, Say.Timeout)) got.Add(item);
                Say.That("all in order", string.Join(",", got));
                writer.Join();
            }
            Say.Throws("negative capacity", () => _ = new NetMQQueue<int>(-1));

            var heard = new List<int>();
            using var poller = new NetMQPoller { queue };
            queue.ReceiveReady += (_, e) =>
            {
                while (e.Queue.TryDequeue(out var next, TimeSpan.Zero)) heard.Add(next);
                if (heard.Count == 400) poller.Stop();
            };
            var threads = Enumerable.Range(0, 4).Select(n => new Thread(() =>
            {
                for (var i = 0; i < 100; i++) queue.Enqueue(n * 100 + i);
            })).ToList();
            foreach (var thread in threads) thread.Start();
            poller.Run();
            Say.That("from four threads", heard.Count);
            Say.That("each in order",
                Enumerable.Range(0, 4).All(n =>
                    heard.Where(x => x / 100 == n).SequenceEqual(Enumerable.Range(n * 100, 100))));
            foreach (var thread in threads) thread.Join();
        }

        private static void Tasks()
        {
            using var poller = new NetMQPoller();
            var here = Environment.CurrentManagedThreadId;
            var ran = 0;
            poller.Run(() => ran = Environment.CurrentManagedThreadId);
            Say.That("at once while it stands still", ran == here);
            poller.RunAsync("named");
            var name = Task.Factory.StartNew(() => Thread.CurrentThread.Name, CancellationToken.None,
                TaskCreationOptions.None, poller);
            Say.That("a task", name.Wait(Say.Timeout) ? name.Result : "did not run");
            Say.That("inline here", poller.CanExecuteTaskInline);
            var answers = new TaskCompletionSource<string>();
            poller.Run(async () =>
            {
                var before = Environment.CurrentManagedThreadId;
                var inline = poller.CanExecuteTaskInline;
                await Task.Delay(10);
                answers.SetResult($"inline {inline}, not here {before != here}, "
                    + $"back on the same thread {before == Environment.CurrentManagedThreadId}");
            });
            Say.That("await", answers.Task.Wait(Say.Timeout) ? answers.Task.Result : "did not come back");
            // A handler is no task: what it awaits comes back because of the poller's SynchronizationContext.
            var handled = new TaskCompletionSource<bool>();
            var timer = new NetMQTimer(1);
            timer.Elapsed += async (_, e) =>
            {
                e.Timer.Enable = false;
                await Task.Delay(10);
                handled.SetResult(poller.CanExecuteTaskInline);
            };
            poller.Add(timer);
            Say.That("await in a handler", handled.Task.Wait(Say.Timeout) && handled.Task.Result);
            var failing = Task.Factory.StartNew(() => throw new InvalidOperationException("on purpose"),
                CancellationToken.None, TaskCreationOptions.None, poller);
            Say.That("a failing task", Say.Thrown(() => failing.Wait(Say.Timeout))?.InnerException?.Message);
            var order = new List<int>();
            for (var i = 0; i < 10; i++)
            {
                var n = i;
                poller.Run(() => order.Add(n));
            }
            poller.Stop();
            Say.That("in order, before it stops", string.Join(",", order));
        }

        private static void Stopping()
        {
            using (var poller = new NetMQPoller())
            {
                Say.ThrowsText("stop what does not run", poller.StopAsync);
                var thread = new Thread(poller.Run) { IsBackground = true };
                thread.Start();
                Say.That("runs", Say.Soon(() => poller.IsRunning));
                poller.Stop();
                Say.That("stopped from another thread", thread.Join(Say.Timeout));
            }
            var asynchronous = new NetMQPoller();
            asynchronous.RunAsync("background", true);
            asynchronous.StopAsync();
            Say.That("stopped without waiting", Say.Soon(() => !asynchronous.IsRunning));
            asynchronous.Dispose();
            var disposed = new NetMQPoller();
            disposed.RunAsync();
            disposed.Dispose();
            Say.That("disposed while running", disposed.IsRunning, disposed.IsDisposed);
            disposed.Dispose();
            Say.Throws("run after that", disposed.Run);
            Say.Throws("stop after that", disposed.Stop);
            Say.Throws("add after that", () => disposed.Add(new NetMQTimer(1)));
            using var own = new NetMQPoller();
            Exception? thrown = null;
            own.RunAsync();
            var done = Task.Factory.StartNew(() => { thrown = Say.Thrown(own.Dispose); }, CancellationToken.None,
                TaskCreationOptions.None, own);
            Say.That("disposed on its own thread", done.Wait(Say.Timeout) ? thrown?.GetType().Name : "no answer");
        }

        private static void Removing()
        {
            using var pull = new PullSocket("@inproc://removing");
            using var push = new PushSocket(">inproc://removing");
            var dropped = new PullSocket("@inproc://dropped");
            using var poller = new NetMQPoller { pull, dropped };
            var got = 0;
            pull.ReceiveReady += (_, e) =>
            {
                e.Socket.SkipFrame();
                Interlocked.Increment(ref got);
            };
            poller.RunAsync();
            Say.That("contains", poller.ContainsAsync(pull).Result, poller.ContainsAsync(dropped).Result);
            poller.RemoveAndDispose(dropped);
            Say.That("removed and disposed", Say.Soon(() => dropped.IsDisposed));
            push.SendFrame("x");
            Say.That("the other one goes on", Say.Soon(() => got == 1));
            poller.Remove(pull);
            Say.That("contains", poller.ContainsAsync(pull).Result);
            push.SendFrame("y");
            Thread.Sleep(Say.Moment);
            Say.That("not heard after that", got);
            poller.Add(pull);
            Say.That("heard again", Say.Soon(() => got == 2));
            Say.Throws("add nothing", () => poller.Add((ISocketPollable)null!));
            Say.ThrowsText("add what is disposed", () => poller.Add(dropped));
            Say.ThrowsText("remove what is disposed", () => poller.Remove(dropped));
            poller.Stop();
            Say.That("contains after it stopped", poller.ContainsAsync(pull).Result);
            var late = new PairSocket();
            var careless = new NetMQPoller { late };
            late.Dispose();
            Say.ThrowsText("disposed inside a poller", careless.Dispose);
        }
    }
}
