// Lesson 09, environment: connects a simulation with a Gymnasium environment in Python.
//
// It says hello with the simulation's name, spaces and dt; then it answers resets and steps (Records.cs), and render,
// until close. Each try to connect has a new socket.
// The Python side is python/netmq_example/envs/gym_env.py.
// Trouble: stop the Python program while it steps, and start it again.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Threading;

namespace NetMQExample
{
    /// <summary>Serves an environment, and after it the next one. Make it, use it and dispose it on one thread, and not
    /// on Unity's main thread: it waits for requests.</summary>
    public sealed class EnvironmentClient : IDisposable
    {
        // For a connection, and then for the answer to hello: so long waits the first try.
        private static readonly TimeSpan Try = TimeSpan.FromSeconds(1);

        private const string Nothing = "no connection", Gone = "the environment is gone, or silent";

        private readonly StepRequest step = new StepRequest();
        private readonly Stopwatch silence = new Stopwatch();
        private readonly MessageDealer dealer;
        private readonly string endpoint;
        private readonly TimeSpan timeout;
        private readonly Action<string> report;
        // The last request, where it was in words; else null, and it is in `step`.
        private Message request;
        // Without a request for so long it says hello again.
        private TimeSpan idle;
        // Why it is in no environment.
        private string why = Nothing;
        private int tries;
        private bool welcomed;

        /// <summary>Connects, which succeeds even while no environment is there.</summary>
        /// <param name="endpoint">The environment, such as <c>tcp://127.0.0.1:5559</c>.</param>
        /// <param name="timeout">How long to wait for one; 30 s when left out.</param>
        /// <param name="report">Called, on the thread that runs, with a line about what happens; or null.</param>
        /// <exception cref="ArgumentException">One of them cannot work; the message names cause and cure.</exception>
        public EnvironmentClient(string endpoint, TimeSpan? timeout = null, Action<string> report = null)
        {
            this.endpoint = endpoint;
            this.timeout = Require.Seconds("timeout", timeout ?? TimeSpan.FromSeconds(30));
            this.report = report ?? (line => { });
            dealer = new MessageDealer(endpoint, timeout) { Gone = Gone };
        }

        // Whether an environment that is lost, or refuses this simulator, is the last one.
        internal bool Once { get; set; }

        /// <summary>Serves until it is closed.</summary>
        /// <param name="count">Or until it is asked for more episodes than this; 0 is no limit.</param>
        /// <param name="perform">Calls what it is given, on the simulation's own thread, and returns then. While the
        /// simulator is waiting, it is called once for each frame.</param>
        /// <param name="stop">Ends it early, within 50 ms of being cancelled.</param>
        /// <exception cref="TimeoutException">There was no environment for too long.</exception>
        public void Run(
            SimulatorBase simulator, int count, Action<Action> perform, CancellationToken stop = default) =>
            Keep(limit => Talk(simulator, count, perform, limit, stop), stop);

        /// <summary>Connects a simulator of this thread, which is made to wait for Python.</summary>
        /// <exception cref="TimeoutException">There was no environment for too long.</exception>
        internal void Join(SimulatorBase simulator) =>
            Keep(limit => Greet(simulator, work => work(), limit, default), default);

        /// <summary>For a simulator of this thread: answers until there is a request for which a frame must pass, and
        /// that one when it is called again.</summary>
        /// <returns>False: the environment was closed.</returns>
        /// <exception cref="TimeoutException">It is gone.</exception>
        internal bool Next(SimulatorBase simulator)
        {
            for (var again = simulator.Waiting; again || Hear(default); again = false)
            {
                Answer(simulator);
                if (simulator.Waiting) return true;
                Reply(simulator, default);
            }
            return false;
        }

        public override string ToString() => $"EnvironmentClient {endpoint}";

        public void Dispose() => dealer.Dispose();

        // Tries it until it succeeds.
        private void Keep(Action<TimeSpan> talk, CancellationToken stop)
        {
            Launcher.Watch();
            TimeSpan left;
            for (silence.Restart(); (left = timeout - silence.Elapsed) > TimeSpan.Zero; dealer.Close())
            {
                var limit = NetMQConnection.Longer(Try, tries++);
                try
                {
                    talk(limit < left ? limit : left);
                    return;
                }
                catch (Exception e) when (e is TimeoutException || e is MessageException)
                {
                    // It is told at once, and once; a refusal says more than the silence that may come after it.
                    if (why != e.Message && (why == Nothing || e is MessageException)) report($"trouble: {e.Message}");
                    if (e is MessageException || why == Nothing) why = e.Message;
                    if (Once && (welcomed || e is MessageException)) throw;
                    // A peer that refuses at once is not asked again at once.
                    stop.WaitHandle.WaitOne(timeout < Try ? timeout : Try / 5);
                }
            }
            var keys = NetMQConnection.Prepare == null ? "" : ", and has this simulator's key on its list";
            throw new TimeoutException(FormattableString.Invariant(
                $"no environment at {endpoint} within {timeout.TotalSeconds} s; ")
                + dealer.Cure($"is the server running{keys}? ({why})"));
        }

        private void Greet(SimulatorBase simulator, Action<Action> perform, TimeSpan limit, CancellationToken stop)
        {
            dealer.Timeout = limit;
            try { perform(() => simulator.Hello()); }
            catch (Exception e) when (e is MessageException || e is ArgumentException)
            {
                // The scene is wrong: Python, which waits for it, is told why it ends.
                var why = e is MessageException known ? known.Text : e.Message;
                dealer.Flush(1);
                dealer.Send(new Message("error") { Values = { ["code"] = "gave-up", ["text"] = why } }, stop);
                throw new GaveUpException(why);
            }
            // Not the simulator's own: in Unity it is asked on the main thread alone.
            var name = simulator.Reply.Values["name"];
            dealer.Send(simulator.Reply, stop);
            request = Receive(limit, stop, "it is there and says nothing: has it another scene, or is it busy?");
            if (request?.Kind != "welcome") throw new MessageException("no-welcome", "hello had another answer");
            welcomed = true;
            dealer.Timeout = Try;
            report($"simulating {name} for {endpoint}");
            // A learner may be silent for an hour; lesson 17's hub never is, and says for how long at most.
            idle = TimeSpan.FromSeconds(
                request.Values.GetValueOrDefault("silence") is double s && s > 0 && s < 3600 ? s : 3600);
        }

        private void Talk(
            SimulatorBase simulator, int count, Action<Action> perform, TimeSpan limit, CancellationToken stop)
        {
            Greet(simulator, perform, limit, stop);
            Action answer = () => Answer(simulator);
            try
            {
                while (Hear(stop))
                {
                    var resets = request == null && step.Has(Order.Reset);
                    if (count > 0 && resets && simulator.Episodes >= count) return;
                    // With the autoreset bit an episode more begins before anybody asks for it.
                    if (count > 0 && request == null && step.Autoreset && simulator.Episodes > count) return;
                    do perform(answer);
                    while (simulator.Waiting);
                    Reply(simulator, stop);
                }
            }
            finally
            {
                silence.Restart();
                why = Nothing;
                tries = 0;
            }
        }

        // The next request; false: the environment was closed.
        private bool Hear(CancellationToken stop)
        {
            request = Receive(idle, stop);
            if (request?.Kind != "close") return true;
            // For the last answer; else it would be dropped.
            dealer.Flush(1);
            dealer.Send(new Message("closed", request.Id), stop);
            return false;
        }

        private void Answer(SimulatorBase simulator)
        {
            if (request == null) simulator.Answer(step);
            else simulator.Answer(request);
        }

        private void Reply(SimulatorBase simulator, CancellationToken stop)
        {
            // Copied: a picture that is drawn anew meanwhile is another one.
            if (simulator.Reply != null) dealer.Send(simulator.Reply, stop, copies: true);
            else dealer.Send(simulator.Frame.Span, stop);
        }

        // A request in words; null: a reset or a step, which then is in `step`.
        private Message Receive(TimeSpan limit, CancellationToken stop, string silent = Gone)
        {
            if (!dealer.TryReceive(limit, stop)) throw new TimeoutException(silent);
            if (!dealer.IsRecord(out var record)) return dealer.Read();
            step.Read(record);
            return null;
        }
    }
}
