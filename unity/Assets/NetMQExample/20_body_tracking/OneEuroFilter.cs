// Application 20, smoothing: webcam poses tremble, and come 30 times a second where Unity shows 60 frames.
//
// The One Euro filter (Casiez, Roussel, Vogel 2012) is a low-pass filter whose cutoff frequency rises with the speed:
// a person who stands still does not tremble, and one who moves is followed at once. An average of the last poses does
// one or the other. A limit of speed is added: after a restart of the server, or when two persons are mixed up, the
// body gets there within some frames and does not jump. It needs neither NetMQ nor UnityEngine.
using System;

namespace NetMQExample
{
    /// <summary>Smooths numbers that change together. Step it once in each frame.</summary>
    public sealed class OneEuroFilter
    {
        // For landmarks in metres; other units want other numbers. In Hz, at rest: a lower one trembles less.
        private const double Cutoff = 1.5;
        // How much the cutoff rises with the speed, in Hz for each metre a second: a higher one follows sooner.
        private const double Beta = 5;
        // No number changes faster, in metres a second.
        private const double Fastest = 6;
        private readonly double[] speeds;

        public OneEuroFilter(int count)
        {
            Values = new double[count];
            speeds = new double[count];
        }

        /// <summary>Whether there was a step: before it the values are no place.</summary>
        public bool Begun { get; private set; }

        public double[] Values { get; }

        /// <summary>Moves the values towards the target.</summary>
        /// <param name="dt">Seconds since the step before.</param>
        public void Step(double[] target, double dt)
        {
            // Unity shows a frame of no time while the game is paused.
            if (dt <= 0 && Begun) return;
            for (var i = 0; i < Values.Length; i++)
            {
                if (!Begun) Values[i] = target[i];
                var way = target[i] - Values[i];
                if (way == 0 && speeds[i] == 0) continue;
                // The speed is smoothed too, with 1 Hz.
                speeds[i] += Share(1, dt) * (way / dt - speeds[i]);
                var move = Share(Cutoff + Beta * Math.Abs(speeds[i]), dt) * way;
                Values[i] += Math.Max(-Fastest * dt, Math.Min(Fastest * dt, move));
            }
            Begun = true;
        }

        // How much of the way a low-pass filter of this frequency goes in one step.
        private static double Share(double frequency, double dt)
        {
            var turned = 2 * Math.PI * frequency * dt;
            return turned / (turned + 1);
        }
    }
}
