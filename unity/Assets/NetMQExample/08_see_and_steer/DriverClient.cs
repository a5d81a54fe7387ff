// Lesson 08, see and steer: asks Python what to do about a picture.
//
// The Python side is python/08_see_and_steer/server.py.
// Bytes: messages of lesson 05. A request of kind `frame` has the picture's number as its id and as the value `frame`,
// and CameraPictures.cs says what else; its reply is of kind `action`, with the values `frame`, `throttle`, `brake`,
// `steer` and those of your own.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Globalization;
using System.Linq;
using System.Threading;

namespace NetMQExample
{
    /// <summary>An action, and the picture that it answers.</summary>
    public readonly struct DriveAction
    {
        private readonly Dictionary<string, object> values;

        /// <summary>Each number is put back into its range.</summary>
        public DriveAction(long frame, double throttle, double brake, double steer, double milliseconds = 0,
            Dictionary<string, object> values = null)
        {
            this.values = values;
            Frame = frame;
            Throttle = Math.Clamp(throttle, -1, 1);
            Brake = Math.Clamp(brake, 0, 1);
            Steer = Math.Clamp(steer, -1, 1);
            Milliseconds = milliseconds;
        }

        public long Frame { get; }

        /// <summary>-1, backwards, to 1.</summary>
        public double Throttle { get; }

        /// <summary>0 to 1.</summary>
        public double Brake { get; }

        /// <summary>-1, left, to 1, right.</summary>
        public double Steer { get; }

        /// <summary>How long it took from sending the picture to this answer.</summary>
        public double Milliseconds { get; }

        /// <summary>A number of your own, which Python returned beside the three; true is 1, false 0.</summary>
        /// <param name="name">Its name there, such as <c>zoom</c>.</param>
        /// <param name="otherwise">The result where Python returned no such number.</param>
        public double Value(string name, double otherwise = 0) => Find(name) is object value
            && !(value is string) ? Convert.ToDouble(value, CultureInfo.InvariantCulture) : otherwise;

        /// <summary>A text of your own, or null where Python returned none.</summary>
        public string Text(string name = "text") => Find(name) as string;

        private object Find(string name) => name switch
        {
            "frame" => Frame,
            "throttle" => Throttle,
            "brake" => Brake,
            "steer" => Steer,
            _ => values != null && values.TryGetValue(name, out var value) ? value : null,
        };
    }

    /// <summary>Asks for actions, and waits for them: not on Unity's main thread. Make it, use it and dispose it in one
    /// thread at a time.</summary>
    public sealed class DriverClient : IDisposable
    {
        private const int OfTheLesson = 4;

        private readonly Message reply = new Message(new MessageStore(true));
        private readonly PooledRequester requester;
        private readonly string endpoint;
        private readonly TimeSpan timeout;
        private readonly int tries;
        private readonly Action<string> report;
        private int lost;

        /// <summary>Connects, which succeeds even while no server is there: ZeroMQ goes on trying.</summary>
        /// <param name="endpoint">The server, such as <c>tcp://127.0.0.1:5558</c>.</param>
        /// <param name="timeout">How long to wait for an action, 1 s when left out; after each that did not come twice
        /// as long, up to 8 times.</param>
        /// <param name="tries">Pictures in a row that may stay without an action.</param>
        /// <param name="report">Called, on the thread that asks, with a line about each that has none, unless it is
        /// null.</param>
        /// <exception cref="ArgumentException">One of them cannot work; the message names cause and cure.</exception>
        public DriverClient(string endpoint, TimeSpan? timeout = null, int tries = 5, Action<string> report = null)
        {
            this.endpoint = endpoint;
            this.timeout = Require.Seconds("timeout", timeout ?? TimeSpan.FromSeconds(1));
            this.tries = Require.Count("tries", tries);
            this.report = report ?? (line => { });
            PooledBuffers.Use();
            requester = new PooledRequester(endpoint);
        }

        /// <summary>Sends a picture and waits for its action. A picture without one is not sent again: by then there is
        /// a newer one.</summary>
        /// <param name="frame">The message that <see cref="CameraPictures.ToMessage"/> made.</param>
        /// <returns>The action, or null if there is none.</returns>
        /// <exception cref="TimeoutException">Too many in a row had none, and the last had no reply.</exception>
        /// <exception cref="MessageException">The last had a reply that is no action.</exception>
        public DriveAction? Ask(Message frame, CancellationToken stop = default)
        {
            Require.Given("frame", frame);
            var start = Stopwatch.GetTimestamp();
            try
            {
                requester.Request(frame, reply, NetMQConnection.Longer(timeout, lost), stop);
                var answered = Take("frame");
                if (answered != frame.Id)
                    throw new MessageException("wrong-frame", FormattableString.Invariant(
                        $"an action for picture {answered}, but {frame.Id} was asked about"));
                var milliseconds = 1000.0 * (Stopwatch.GetTimestamp() - start) / Stopwatch.Frequency;
                var action = new DriveAction(frame.Id, Take("throttle"), Take("brake"), Take("steer"), milliseconds,
                    reply.Values.Count > OfTheLesson ? Kept(reply.Values) : null);
                lost = 0;
                return action;
            }
            catch (Exception e) when (e is TimeoutException || e is MessageException)
            {
                lost++;
                if (lost >= tries) throw;
                report($"trouble: {e.Message}");
                return null;
            }
        }

        private double Take(string name)
        {
            reply.Values.TryGetValue(name, out var value);
            return reply.Kind == "action" && value is MessageNumber number ? number.Real
                : throw new MessageException("no-action", $"the reply is no action, or without a number '{name}'");
        }

        // The next reply goes where this one is.
        private static Dictionary<string, object> Kept(Dictionary<string, object> values) =>
            values.ToDictionary(one => one.Key, one => one.Value is MessageNumber number ? number.Kept : one.Value);

        public override string ToString() => $"DriverClient {endpoint}";
        public void Dispose() => requester.Dispose();
    }
}
