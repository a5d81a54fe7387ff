// What another thread may do to a socket in use, by mistake: it must end in an exception, and not the process.
//
// Only for the libzmq engine: in NetMQ who waits on a socket that was disposed waits for ever, and Cleanup and a
// constructor can wait for each other.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample.Conformance
{
    internal static class Threads
    {
        private static readonly TimeSpan longer = TimeSpan.FromSeconds(60);

        internal static void Run()
        {
            DisposedInUse("receiving", socket => socket.ReceiveFrameString());
            DisposedInUse("receiving with a limit", socket => socket.TryReceiveFrameString(longer, out _));
            DisposedInUse("sending", socket => socket.SendFrame("for nobody"));
            DisposedInUse("sending with a limit", socket => socket.TrySendFrame(longer, "for nobody"));
            DisposedInUse("polling", socket => socket.Poll(PollEvents.PollIn, longer));
            DisposedAtWork();
            CleanupAgainstConstructors();
            NetMQConfig.Cleanup();
            Say.That("and all was closed", true);
        }

        private static void DisposedInUse(string what, Action<NetMQSocket> wait)
        {
            var socket = new DealerSocket();
            using var waiting = new ManualResetEventSlim();
            var waiter = Task.Factory.StartNew(() =>
            {
                waiting.Set();
                return Say.Thrown(() => wait(socket));
            }, TaskCreationOptions.LongRunning);
            waiting.Wait(Say.Timeout);
            Thread.Sleep(50);
            socket.Dispose();
            Say.That($"disposed while {what}", Ended(waiter));
        }

        private static string Ended(Task<Exception?> waiter)
            => waiter.Wait(Say.Timeout) ? waiter.Result?.GetType().Name ?? "nothing thrown" : "still waits";

        /// <summary>At any moment of a call, and not only while it waits.</summary>
        private static void DisposedAtWork()
        {
            var kinds = new HashSet<string>();
            for (var round = 0; round < 60; round++)
            {
                using var pull = new PullSocket("@tcp://127.0.0.1:0");
                using var push = new PushSocket(pull.Options.LastEndpoint!.Insert(0, ">"));
                using var busy = new CountdownEvent(2);
                Task<Exception?> Work(Action work) => Task.Factory.StartNew(() => Say.Thrown(() =>
                {
                    for (var i = 0; ; i++)
                    {
                        work();
                        if (i == 5) busy.Signal();
                    }
                }), TaskCreationOptions.LongRunning);
                var large = new byte[2000];
                var sender = Work(() => push.TrySendFrame(longer, large));
                var receiver = Work(() => pull.TryReceiveFrameBytes(longer, out _));
                busy.Wait(Say.Timeout);
                Thread.SpinWait(round * 300);
                pull.Dispose();
                push.Dispose();
                kinds.Add(Ended(sender));
                kinds.Add(Ended(receiver));
            }
            Say.That("disposed at work, 60 times", string.Join(" ", kinds));
        }

        private static void CleanupAgainstConstructors()
        {
            var kinds = new HashSet<string>();
            var stop = false;
            var made = 0;
            var makers = Enumerable.Range(0, 4).Select(_ => Task.Factory.StartNew(() =>
            {
                while (!Volatile.Read(ref stop))
                {
                    var thrown = Say.Thrown(() => new DealerSocket().Dispose());
                    Interlocked.Increment(ref made);
                    // libzmq ends a closed socket a little later, and this loop does not wait for that.
                    if (thrown is NetMQException { ErrorCode: ErrorCode.TooManyOpenSockets }) continue;
                    if (thrown != null) lock (kinds) kinds.Add(thrown.GetType().Name);
                }
            }, TaskCreationOptions.LongRunning)).ToArray();
            var cleaner = Task.Factory.StartNew(() =>
            {
                for (var i = 0; i < 200 || Volatile.Read(ref made) < 5000; i++) NetMQConfig.Cleanup(i % 2 == 0);
            }, TaskCreationOptions.LongRunning);
            Say.That("Cleanup against constructors", cleaner.Wait(TimeSpan.FromSeconds(100)));
            Volatile.Write(ref stop, true);
            Say.That("the constructors ended", Task.WaitAll(makers, Say.Timeout));
            Say.That("and threw at the most", kinds.Count == 0 ? "TerminatingException" : string.Join(" ", kinds));
        }
    }
}
