// Lesson 09, real time: the world goes on while Python thinks, for whoever asks for it. In Python: scene/real_time.py.
//
// Each exchange first makes up for the ticks that the clock has seen since the last one, with the actions from then;
// the tick that is due now has the new ones. Each tick is a step, and rewards are summed. It is Python that keeps the
// pace: it sends no more than one step for each tick.
using System;
using System.Diagnostics;

namespace NetMQExample
{
    /// <summary>Says how much time is to be made up for.</summary>
    internal sealed class RealTimeClock
    {
        // Seconds. After a longer sleep of the computer it makes up for no more than this.
        private const double MostSeconds = 10;

        private readonly Stopwatch clock = Stopwatch.StartNew();
        private double next;

        public bool On { get; private set; }

        public void Switch(bool on)
        {
            if (on && !On) Restart();
            On = on;
        }

        public void Restart() => next = clock.Elapsed.TotalSeconds;

        /// <summary>Whether one more tick of so many seconds is due, or was before the last ones.</summary>
        public bool IsDue(double seconds, double but)
        {
            var until = clock.Elapsed.TotalSeconds - but;
            next = Math.Max(next, until - MostSeconds);
            if (!On || until < next + seconds) return false;
            next += seconds;
            return true;
        }

        // A tick was done that was asked for.
        public void Pass(double seconds) => next += seconds;
    }
}
