// One thread that watches many sockets, timers and queues, and runs what others ask it to run.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Threading;
using System.Threading.Tasks;

namespace NetMQ
{
    /// <summary>What every poller can do.</summary>
    public interface INetMQPoller : IDisposable
    {
        /// <summary>True while it runs.</summary>
        bool IsRunning { get; }

        /// <summary>Runs on this thread until it is stopped.</summary>
        void Run();

        /// <summary>Runs on a thread of its own.</summary>
        void RunAsync();

        /// <summary>Stops it and waits until it stands still.</summary>
        void Stop();

        /// <summary>Stops it without waiting.</summary>
        void StopAsync();

        /// <summary>Watches a socket.</summary>
        void Add(ISocketPollable socket);

        /// <summary>Watches a socket no longer.</summary>
        void Remove(ISocketPollable socket);

        /// <summary>Watches a socket no longer, and disposes it on the poller's thread.</summary>
        void RemoveAndDispose<T>(T socket) where T : ISocketPollable, IDisposable;
    }

    /// <summary>
    /// Raises the events of sockets, queues and timers, one after the other, on the thread that runs it. As a
    /// <see cref="TaskScheduler"/> it runs tasks there as well; what its handlers await continues there.
    /// </summary>
    public sealed class NetMQPoller : TaskScheduler, INetMQPoller, IEnumerable
    {
        private readonly List<NetMQSocket> sockets = new List<NetMQSocket>();
        private readonly List<NetMQTimer> timers = new List<NetMQTimer>();
        private readonly NetMQQueue<Task?> tasks = new NetMQQueue<Task?>();
        private readonly object gate = new object();
        private volatile bool running;
        private volatile bool stopRequested;
        private volatile bool changed = true;
        private volatile int threadId = -1;
        private int disposed;

        /// <summary>Watches nothing yet.</summary>
        public NetMQPoller() => tasks.ReceiveReady += (_, _) => RunTasks();

        /// <summary>True while it runs.</summary>
        public bool IsRunning => running;

        /// <summary>True once it was disposed.</summary>
        public bool IsDisposed => disposed == 2;

        /// <summary>True on the thread that runs it.</summary>
        public bool CanExecuteTaskInline => threadId == Environment.CurrentManagedThreadId;

        /// <summary>It has one thread.</summary>
        public override int MaximumConcurrencyLevel => 1;

        /// <summary>Watches a socket or a queue.</summary>
        public void Add(ISocketPollable socket)
        {
            CheckArgument(socket);
            Run(() =>
            {
                CheckStillThere(socket, nameof(Add));
                if (sockets.Contains(socket.Socket)) return;
                sockets.Add(socket.Socket);
                socket.Socket.EventsChanged += OnChanged;
                changed = true;
            });
        }

        /// <summary>Lets a timer tick.</summary>
        public void Add(NetMQTimer timer)
        {
            if (timer == null) throw new ArgumentNullException(nameof(timer));
            CheckDisposed();
            Run(() => timers.Add(timer));
        }

        /// <summary>Watches a socket or a queue no longer.</summary>
        public void Remove(ISocketPollable socket)
        {
            CheckArgument(socket);
            Run(() =>
            {
                CheckStillThere(socket, nameof(Remove));
                Forget(socket.Socket);
            });
        }

        /// <summary>Watches a socket or a queue no longer, and disposes it on the poller's thread.</summary>
        public void RemoveAndDispose<T>(T socket) where T : ISocketPollable, IDisposable
        {
            CheckArgument(socket);
            Run(() =>
            {
                CheckStillThere(socket, nameof(RemoveAndDispose));
                Forget(socket.Socket);
                socket.Dispose();
            });
        }

        /// <summary>Lets a timer tick no longer.</summary>
        public void Remove(NetMQTimer timer)
        {
            if (timer == null) throw new ArgumentNullException(nameof(timer));
            CheckDisposed();
            timer.When = -1;
            Run(() => timers.Remove(timer));
        }

        /// <summary>True if it watches the socket.</summary>
        public Task<bool> ContainsAsync(ISocketPollable socket)
        {
            if (socket == null) throw new ArgumentNullException(nameof(socket));
            return Ask(() => sockets.Contains(socket.Socket));
        }

        /// <summary>True if it has the timer.</summary>
        public Task<bool> ContainsAsync(NetMQTimer timer)
        {
            if (timer == null) throw new ArgumentNullException(nameof(timer));
            return Ask(() => timers.Contains(timer));
        }

        /// <summary>
        /// Runs something on the poller's thread: at once if this is it or it does not run, later otherwise.
        /// </summary>
        public void Run(Action action)
        {
            if (!IsRunning || CanExecuteTaskInline) action();
            else new Task(action).Start(this);
        }

        /// <summary>Runs on a thread of its own.</summary>
        public void RunAsync() => RunAsync("NetMQPoller");

        /// <summary>Runs on a thread of its own that has this name.</summary>
        public void RunAsync(string threadName) => RunAsync(threadName, false);

        /// <summary>Runs on a thread of its own, which may let the program end.</summary>
        public void RunAsync(string threadName, bool isBackgroundThread)
        {
            CheckCanStart();
            using var started = new ManualResetEventSlim();
            var thread = new Thread(() => Run(new PollerContext(this), started))
            {
                Name = threadName,
                IsBackground = isBackgroundThread,
            };
            thread.Start();
            started.Wait();
        }

        /// <summary>Runs on this thread until it is stopped.</summary>
        public void Run() => Run(new PollerContext(this));

        /// <summary>Runs on this thread with a synchronization context.</summary>
        public void Run(SynchronizationContext syncContext)
        {
            if (syncContext == null) throw new ArgumentNullException("Must supply a Synchronization Context");
            Run(syncContext, null);
        }

        /// <summary>Stops it and waits until it stands still, except on its own thread.</summary>
        public void Stop()
        {
            CheckDisposed();
            RequestStop();
            if (!CanExecuteTaskInline) WaitUntilStopped();
        }

        /// <summary>Stops it without waiting.</summary>
        public void StopAsync()
        {
            CheckDisposed();
            if (!IsRunning) throw new InvalidOperationException("NetMQPoller is not running");
            RequestStop();
        }

        /// <summary>Stops it. Its sockets stay open.</summary>
        public void Dispose()
        {
            if (CanExecuteTaskInline)
            {
                throw new InvalidOperationException("Cannot dispose poller from the poller thread.");
            }
            if (Interlocked.CompareExchange(ref disposed, 1, 0) != 0) return;
            if (IsRunning)
            {
                RequestStop();
                WaitUntilStopped();
            }
            tasks.Dispose();
            foreach (var socket in sockets)
            {
                if (socket.IsDisposed)
                {
                    throw new NetMQException(
                        "Invalid state detected: NetMQPoller contains a disposed NetMQSocket. Sockets must be either "
                        + "removed before being disposed, or disposed after the poller is disposed.");
                }
                socket.EventsChanged -= OnChanged;
            }
            disposed = 2;
        }

        // For `new NetMQPoller { socket, timer }`, which needs an enumerable.
        IEnumerator IEnumerable.GetEnumerator()
        {
            yield break;
        }

        /// <inheritdoc/>
        protected override void QueueTask(Task task)
        {
            if (disposed != 0) throw new ObjectDisposedException(nameof(NetMQPoller));
            tasks.Enqueue(task);
        }

        /// <inheritdoc/>
        protected override bool TryExecuteTaskInline(Task task, bool taskWasPreviouslyQueued)
            => !IsDisposed && CanExecuteTaskInline && TryExecuteTask(task);

        /// <inheritdoc/>
        protected override IEnumerable<Task> GetScheduledTasks() => throw new NotSupportedException();

        private void Run(SynchronizationContext syncContext, ManualResetEventSlim? started)
        {
            CheckCanStart();
            var before = SynchronizationContext.Current;
            SynchronizationContext.SetSynchronizationContext(syncContext);
            threadId = Environment.CurrentManagedThreadId;
            running = true;
            started?.Set();
            try
            {
                Loop();
            }
            finally
            {
                // NetMQ's poller watches nothing any more after it was stopped.
                foreach (var socket in sockets.ToArray()) Forget(socket);
                stopRequested = false;
                threadId = -1;
                SynchronizationContext.SetSynchronizationContext(before);
                lock (gate)
                {
                    running = false;
                    Monitor.PulseAll(gate);
                }
            }
        }

        private void Loop()
        {
            var pollSet = new PollSet(Array.Empty<NetMQSocket>());
            var watched = Array.Empty<NetMQSocket>();
            foreach (var timer in timers) timer.Schedule();
            while (!stopRequested)
            {
                if (changed)
                {
                    changed = false;
                    watched = new NetMQSocket[sockets.Count + 1];
                    sockets.CopyTo(watched, 1);
                    watched[0] = ((ISocketPollable)tasks).Socket;
                    pollSet = new PollSet(watched);
                }
                var ready = pollSet.Wait(TimeToNextTick());
                // By index, since a handler may add or remove timers.
                for (var i = 0; i < timers.Count; i++)
                {
                    var timer = timers[i];
                    if (timer.When != -1 && timer.When <= NetMQTimer.Now) timer.Tick(this);
                }
                for (var i = 0; ready && i < watched.Length; i++)
                {
                    var events = pollSet.Ready(i);
                    if (events != PollEvents.None) watched[i].RaiseEvents(this, events);
                }
            }
            RunTasks();
        }

        private int TimeToNextTick()
        {
            var now = NetMQTimer.Now;
            long left = int.MaxValue;
            foreach (var timer in timers)
            {
                if (timer.When == -1 && timer.Enable) timer.Schedule();
                if (timer.When != -1) left = Math.Min(left, timer.When - now);
            }
            return (int)Math.Max(0, left);
        }

        private void RunTasks()
        {
            while (tasks.TryDequeue(out var task, TimeSpan.Zero))
            {
                if (task != null) TryExecuteTask(task);
            }
        }

        private void RequestStop()
        {
            stopRequested = true;
            // An item in the queue ends the wait for sockets.
            tasks.Enqueue(null);
        }

        private void WaitUntilStopped()
        {
            lock (gate)
            {
                while (running) Monitor.Wait(gate);
            }
        }

        private Task<bool> Ask(Func<bool> question)
        {
            CheckDisposed();
            var answer = new TaskCompletionSource<bool>();
            Run(() => answer.SetResult(question()));
            return answer.Task;
        }

        private void Forget(NetMQSocket socket)
        {
            socket.EventsChanged -= OnChanged;
            sockets.Remove(socket);
            changed = true;
        }

        private void OnChanged() => changed = true;

        private void CheckArgument(ISocketPollable socket)
        {
            if (socket == null) throw new ArgumentNullException(nameof(socket));
            if (socket.IsDisposed) throw new ArgumentException("Must not be disposed.", nameof(socket));
            CheckDisposed();
        }

        private static void CheckStillThere(ISocketPollable socket, string operation)
        {
            if (!socket.IsDisposed) return;
            throw new InvalidOperationException(
                $"NetMQPoller.{operation} was called from a non-poller thread, and the {socket.GetType().Name} was "
                + "disposed before the poller thread came to it. Use RemoveAndDispose, or dispose the poller first.");
        }

        private void CheckCanStart()
        {
            CheckDisposed();
            if (IsRunning) throw new InvalidOperationException("NetMQPoller is already running");
        }

        private void CheckDisposed()
        {
            if (IsDisposed) throw new ObjectDisposedException(nameof(NetMQPoller));
        }

        private sealed class PollerContext : SynchronizationContext
        {
            private readonly NetMQPoller poller;

            internal PollerContext(NetMQPoller poller) => this.poller = poller;

            public override void Post(SendOrPostCallback d, object? state) => new Task(() => d(state)).Start(poller);

            public override void Send(SendOrPostCallback d, object? state)
            {
                var task = new Task(() => d(state));
                task.Start(poller);
                task.Wait();
            }
        }
    }
}
