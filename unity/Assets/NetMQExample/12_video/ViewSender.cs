// Lesson 12, video: offers a game's views to Python, and sends what it asks for.
//
// It says hello with the views' names and largest sizes; then Python begins and ends films, whenever it wants to. When
// Python is gone no more pictures are taken; the game goes on, and when Python is back it is offered the views again.
// Each try to connect has a new socket.
// The Python side is netmq_example/video/films.py; a sender in Python is netmq_example/video/view_sender.py.
// Trouble: stop the Python program while it films, and start it again.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Linq;
using System.Runtime.InteropServices;
using System.Threading;

namespace NetMQExample
{
    /// <summary>Make it, use it and dispose it on one thread, and not on Unity's main thread: it waits for what Python
    /// wants.</summary>
    public sealed class ViewSender : IDisposable
    {
        // For a connection, and then for the answer to hello: so long waits the first try.
        private static readonly TimeSpan Try = TimeSpan.FromSeconds(1);
        private static readonly string[] Requests = { "begin", "look", "took", "end" };

        private readonly Stopwatch silence = new Stopwatch();
        private readonly MessageDealer dealer;
        private readonly string endpoint;
        private readonly TimeSpan timeout;
        private readonly Action<string> report;
        private volatile bool connected;
        private bool closed;

        /// <summary>Connects, which succeeds even while nobody is there.</summary>
        /// <param name="endpoint">Where Python films, such as <c>tcp://127.0.0.1:5562</c>.</param>
        /// <param name="timeout">How long to wait for it; 30 s when left out.</param>
        /// <param name="report">Called, on the thread that runs, with a line about what happens; or null.</param>
        /// <exception cref="ArgumentException">One of them cannot work; the message names cause and cure.</exception>
        public ViewSender(string endpoint, TimeSpan? timeout = null, Action<string> report = null)
        {
            this.endpoint = endpoint;
            this.timeout = Require.Seconds("timeout", timeout ?? TimeSpan.FromSeconds(30));
            this.report = report ?? (line => { });
            dealer = new MessageDealer(endpoint, timeout);
        }

        /// <summary>Whether Python is there. For any thread.</summary>
        public bool Connected => connected;

        /// <summary>Serves until it is stopped.</summary>
        /// <exception cref="ArgumentException">Two of them have one name, or there are none.</exception>
        /// <exception cref="TimeoutException">Nobody was there for too long.</exception>
        public void Run(IReadOnlyList<FilmView> views, CancellationToken stop = default)
        {
            var names = views.Select(view => view.Name).DefaultIfEmpty("none").ToList();
            if (views.Count == 0 || names.Distinct().Count() < views.Count)
                throw new ArgumentException($"each view needs a name of its own: {string.Join(", ", names)}");
            var why = "";
            var tries = 0;
            TimeSpan left;
            for (silence.Restart();
                (left = timeout - silence.Elapsed) > TimeSpan.Zero && !stop.IsCancellationRequested; dealer.Close())
            {
                var limit = NetMQConnection.Longer(Try, tries++);
                dealer.Timeout = limit < left ? limit : left;
                try { Talk(views, stop); }
                catch (OperationCanceledException)
                {
                    dealer.Flush();
                    return;
                }
                catch (Exception e) when (e is TimeoutException || e is MessageException)
                {
                    why = e.Message;
                    // It does not ask again at once after a refusal.
                    stop.WaitHandle.WaitOne(timeout < Try / 5 ? timeout : Try / 5);
                }
                finally
                {
                    if (connected) tries = 0;
                    connected = false;
                    foreach (var view in views) view.Stop();
                }
            }
            if (!stop.IsCancellationRequested)
                throw new TimeoutException(FormattableString.Invariant(
                    $"nobody films at {endpoint} within {timeout.TotalSeconds} s; is the server running? ({why})"));
        }

        public override string ToString() => $"ViewSender {endpoint}";
        public void Dispose() => dealer.Dispose();

        private void Talk(IReadOnlyList<FilmView> views, CancellationToken stop)
        {
            var hello = new Message("hello");
            hello.Values["views"] = string.Join(",", views.Select(view => view.Name));
            var sizes = views.SelectMany(view => new[] { view.Width, view.Height }).ToArray();
            hello.Arrays.Add(new MessageArray("int32", MemoryMarshal.AsBytes<int>(sizes).ToArray(), views.Count, 2));
            dealer.Send(hello, stop);
            if (dealer.Receive(dealer.Timeout, stop)?.Kind != "welcome")
                throw new MessageException("no-welcome", "no answer to hello");
            report($"{endpoint} can film " + string.Join(", ", views.Select(v => $"{v.Name} {v.Width} x {v.Height}")));
            connected = true;
            closed = false;
            try { while (!closed) Serve(views, stop); }
            catch (Exception e) when (e is TimeoutException || e is MessageException)
            {
                report($"trouble: {e.Message}: no more pictures are taken");
                throw;
            }
            finally { silence.Restart(); }
        }

        private void Serve(IReadOnlyList<FilmView> views, CancellationToken stop)
        {
            var request = dealer.Receive(NetMQConnection.Slice, stop);
            closed = request?.Kind == "close";
            if (closed)
            {
                dealer.Send(new Message("closed", request.Id), stop);
                dealer.Flush();
                // One that leaves behind each welcome is not asked again at once.
                stop.WaitHandle.WaitOne(Try);
                return;
            }
            if (request != null && Array.IndexOf(Requests, request.Kind) >= 0)
                if (Do(views, request) is Message answer) dealer.Send(answer, stop);
            foreach (var message in views.SelectMany(view => view.Outgoing()))
            {
                dealer.Send(message, stop);
                var values = message.Values;
                if (message.Kind == "ended")
                    report($"{values["view"]}: {values["frames"]} pictures, {values["skipped"]} skipped");
            }
        }

        private static Message Do(IReadOnlyList<FilmView> views, Message request)
        {
            try
            {
                var wanted = request.Values.GetValueOrDefault("view") as string ?? "";
                return views.FirstOrDefault(view => view.Name == wanted) is FilmView found
                    ? found.Do(request)
                    : throw new MessageException("unknown-view", $"there is no view {MessageWriter.Shown(wanted)}; "
                        + $"there are: {string.Join(", ", views.Select(view => view.Name))}");
            }
            catch (MessageException e)
            {
                return new Message("error", request.Id) { Values = { ["code"] = e.Code, ["text"] = e.Text } };
            }
        }
    }
}
