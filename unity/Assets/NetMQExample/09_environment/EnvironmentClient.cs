// Lesson 09, environment: connects a simulation with a Gymnasium environment in Python.
//
// It says hello with the simulation's name, spaces and dt; then it answers reset, step and render, until close. Each
// try to connect has a new socket.
// The Python side is python/netmq_example/envs/gym_env.py.
// Trouble: stop the Python program while it steps, and start it again.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Linq;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample
{
    /// <summary>Serves an environment, and after it the next one. Make it, use it and dispose it on one thread, and not
    /// on Unity's main thread: it waits for requests.</summary>
    public sealed class EnvironmentClient : IDisposable
    {
        // For a connection, and then for the answer to hello.
        private static readonly TimeSpan Try = TimeSpan.FromSeconds(1);

        private const string Nothing = "no connection";

        private readonly Stopwatch silence = new Stopwatch();
        private readonly NetMQConnection connection;
        private readonly string endpoint;
        private readonly TimeSpan timeout;
        private readonly Action<string> report;
        // Why it is in no environment.
        private string why = Nothing;

        /// <summary>Connects, which succeeds even while no environment is there.</summary>
        /// <param name="endpoint">The environment, such as <c>tcp://127.0.0.1:5559</c>.</param>
        /// <param name="timeout">How long to wait for one.</param>
        /// <param name="report">Called, on the thread that runs, with a line about what happens.</param>
        /// <exception cref="ArgumentException">One of them cannot work; the message names cause and cure.</exception>
        public EnvironmentClient(string endpoint, TimeSpan timeout, Action<string> report)
        {
            this.endpoint = endpoint;
            this.timeout = Require.Seconds("timeout", timeout);
            this.report = Require.Given("report", report);
            connection = new NetMQConnection(endpoint, () => new DealerSocket
            {
                // Nothing can be sent while there is no connection, and this socket makes no second one: it might do so
                // between two looks, without a hello, and Python and simulator would wait for each other.
                // A pulled cable tells nobody: a silent peer is asked after a second, and gone when two more bring no
                // answer.
                Options = { DelayAttachOnConnect = true, ReconnectInterval = Timeout.InfiniteTimeSpan,
                    HeartbeatInterval = Try, HeartbeatTimeout = Try + Try },
            }, 4 * Message.LimitBytes);
        }

        /// <summary>Serves until it is closed.</summary>
        /// <param name="simulator">What answers.</param>
        /// <param name="count">Or until it is asked for more episodes than this; 0 is no limit.</param>
        /// <param name="perform">Calls what it is given, on the simulation's own thread.</param>
        /// <param name="stop">Ends it early, within 50 ms of being cancelled.</param>
        /// <exception cref="TimeoutException">There was no environment for too long.</exception>
        public void Run(
            SimulatorBase simulator, int count, Func<Func<Message>, Message> perform, CancellationToken stop = default)
        {
            for (silence.Restart(); silence.Elapsed < timeout; connection.Close())
            {
                try
                {
                    Talk(simulator, count, perform, stop);
                    return;
                }
                catch (Exception e) when (e is TimeoutException || e is MessageException)
                {
                    // A refusal is told at once, and once; it says more than the silence that may come after it.
                    if (e is MessageException && why != e.Message) report($"trouble: {e.Message}");
                    if (e is MessageException || why == Nothing) why = e.Message;
                    // Whoever refuses at once is not asked again at once.
                    stop.WaitHandle.WaitOne(timeout < Try ? timeout : Try / 5);
                }
            }
            var keys = NetMQConnection.Prepare == null ? "" : ", and has this simulator's key on its list";
            throw new TimeoutException(FormattableString.Invariant($"no environment at {endpoint} within ")
                + FormattableString.Invariant($"{timeout.TotalSeconds} s; is the server running{keys}? ({why})"));
        }

        /// <summary>Closes the socket, then leaves NetMQ.</summary>
        public void Dispose() => connection.Dispose();

        private void Talk(
            SimulatorBase simulator, int count, Func<Func<Message>, Message> perform, CancellationToken stop)
        {
            var limit = timeout < Try ? timeout : Try;
            var hello = perform(simulator.Hello);
            Send(hello, limit, stop);
            var request = Receive(limit, stop);
            if (request.Kind != "welcome") throw new MessageException("no-welcome", "hello had another answer");
            report($"simulating {hello.Values["name"]} for {endpoint}");
            // Without a request for so long, it says hello again. Who learns may be silent for an hour; lesson 17's hub
            // never is, and says for how long at most.
            var idle = request.Values.GetValueOrDefault("silence") is double s && s > 0 && s < 3600 ? s : 3600;
            try
            {
                while ((request = Receive(TimeSpan.FromSeconds(idle), stop)).Kind != "close")
                {
                    if (request.Kind == "reset" && count > 0 && simulator.Episodes >= count) return;
                    Send(perform(() => simulator.Answer(request)), Try, stop);
                }
                // For the last answer; else it would be dropped.
                connection.Socket.Options.Linger = Try;
                Send(new Message("closed", request.Id), Try, stop);
            }
            catch (TimeoutException e)
            {
                report($"trouble: {e.Message}");
                throw;
            }
            finally
            {
                silence.Restart();
                why = Nothing;
            }
        }

        private void Send(Message message, TimeSpan limit, CancellationToken stop)
        {
            var frames = new NetMQMessage();
            frames.Append(message.Header());
            foreach (var array in message.Arrays) frames.Append(array.Data.ToArray());
            if (!NetMQConnection.Slices(limit, stop).Any(s => connection.Socket.TrySendMultipartMessage(s, frames)))
                throw new TimeoutException(Nothing);
            connection.Show(true, frames);
        }

        private Message Receive(TimeSpan limit, CancellationToken stop)
        {
            var frames = new NetMQMessage();
            foreach (var slice in NetMQConnection.Slices(limit, stop))
            {
                if (!connection.Socket.TryReceiveMultipartMessage(slice, ref frames))
                {
                    if (connection.Socket.HasOut) continue;
                    break;
                }
                connection.Show(false, frames);
                var message = Message.Read(
                    frames.Select(frame => new ReadOnlyMemory<byte>(frame.Buffer, 0, frame.MessageSize)).ToList());
                if (message.Kind != "error") return message;
                var code = message.Values.GetValueOrDefault("code");
                var text = message.Values.GetValueOrDefault("text");
                throw new MessageException(LogText.Printable($"{code}"), LogText.Printable($"{text}"));
            }
            throw new TimeoutException("the environment is gone, or silent");
        }
    }
}
