// Lesson 08, see and steer: asks Python what to do about a picture.
//
// Take home: this file and Shot.cs, with PooledRequester.cs (lesson 05). The Python side is
// python/08_see_and_steer/server.py.
// Bytes: messages of lesson 05. A request of kind `frame` has the picture's number as its id and as the value `frame`,
// and Shot.cs says what else; its reply is of kind `action`, with the values `frame`, `throttle`, `brake` and `steer`.
using System;
using System.Diagnostics;
using System.Globalization;
using System.Threading;

namespace NetMQExample
{
    /// <summary>What to do, and about which picture.</summary>
    public readonly struct DriveAction
    {
        /// <summary>What is out of range is put back into it.</summary>
        public DriveAction(long frame, double throttle, double brake, double steer, double milliseconds = 0) =>
            (Frame, Throttle, Brake, Steer, Milliseconds) = (frame, Math.Clamp(throttle, 0, 1), Math.Clamp(brake, 0, 1),
                Math.Clamp(steer, -1, 1), milliseconds);

        /// <summary>The number of the picture that it answers.</summary>
        public long Frame { get; }

        /// <summary>0 to 1.</summary>
        public double Throttle { get; }

        /// <summary>0 to 1.</summary>
        public double Brake { get; }

        /// <summary>-1, left, to 1, right.</summary>
        public double Steer { get; }

        /// <summary>How long it took from sending the picture to this answer.</summary>
        public double Milliseconds { get; }
    }

    /// <summary>Asks for an action, and waits for it: not on Unity's main thread. Make it, use it and dispose it in one
    /// thread at a time.</summary>
    public sealed class DriverClient : IDisposable
    {
        private readonly PooledRequester requester;

        /// <summary>Connects, which succeeds even while no server is there: ZeroMQ goes on trying.</summary>
        /// <param name="endpoint">The server, such as <c>tcp://127.0.0.1:5558</c>.</param>
        /// <exception cref="ArgumentException">The endpoint cannot work; the message names cause and cure.</exception>
        public DriverClient(string endpoint)
        {
            PooledBuffers.Use();
            requester = new PooledRequester(endpoint);
        }

        /// <summary>Sends a picture and waits for its action.</summary>
        /// <param name="frame">What <see cref="Shot.ToMessage"/> made.</param>
        /// <param name="patience">How long to wait.</param>
        /// <param name="stop">Ends the wait early.</param>
        /// <exception cref="TimeoutException">No reply came. By the next request there is a newer picture: this one is
        /// never sent again.</exception>
        /// <exception cref="MessageException">The server refused it, or its reply is no action for this
        /// picture.</exception>
        public DriveAction Ask(Message frame, TimeSpan patience, CancellationToken stop = default)
        {
            var clock = Stopwatch.StartNew();
            var reply = requester.Request(frame, patience, stop);
            if (reply.Kind != "action") throw new MessageException("no-action", "the reply's kind is not 'action'");
            double Take(string name) =>
                reply.Values.TryGetValue(name, out var value) && (value is double || value is long)
                    ? Convert.ToDouble(value, CultureInfo.InvariantCulture)
                    : throw new MessageException("no-action", $"the reply has no number '{name}'");
            var answered = Take("frame");
            if (answered != frame.Id)
                throw new MessageException("wrong-frame", FormattableString.Invariant(
                    $"an action for picture {answered}, but {frame.Id} was asked about"));
            return new DriveAction(frame.Id, Take("throttle"), Take("brake"), Take("steer"),
                clock.Elapsed.TotalMilliseconds);
        }

        /// <summary>Closes the socket, then leaves NetMQ.</summary>
        public void Dispose() => requester.Dispose();
    }
}
