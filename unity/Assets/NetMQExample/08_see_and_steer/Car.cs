// Lesson 08, the car: a kinematic bicycle, which goes where its wheels point. The Python side is road.py.
//
// No WheelCollider: that cannot run outside Unity, and does not give the same numbers twice.
using System;
using System.Collections.Generic;

namespace NetMQExample
{
    /// <summary>Where the car is, where it looks and how fast it is.</summary>
    public sealed class Car : ICar
    {
        // 2.5 m from axle to axle, with wheels that turn by 22 degrees: tan(22 deg) / 2.5 m.
        private const double Curvature = 0.16, Acceleration = 4, Braking = 8, Drag = 0.2;

        private readonly Road road;

        /// <summary>At a point of the road, looking along it.</summary>
        public Car(Road road, int start)
        {
            this.road = Require.Given("road", road);
            var at = start % road.Points.Length;
            (X, Y) = road.Points[at];
            var (toX, toY) = road.Points[(at + 1) % road.Points.Length];
            var length = Math.Sqrt((toX - X) * (toX - X) + (toY - Y) * (toY - Y));
            (AheadX, AheadY) = ((toX - X) / length, (toY - Y) / length);
        }

        /// <summary>Where it is, in metres.</summary>
        public double X { get; private set; }
        public double Y { get; private set; }

        /// <summary>Where it looks: a direction of length 1.</summary>
        public double AheadX { get; private set; }
        public double AheadY { get; private set; }

        public string Where => FormattableString.Invariant($"{road.Nearest(X, Y).Distance:F1} m off the middle");

        /// <summary>In metres a second, backwards below 0.</summary>
        public double Speed { get; private set; }

        public void Telemetry(IDictionary<string, object> values)
        {
        }

        public void Step(double throttle, double brake, double steer)
        {
            // The brake acts against the way in which it would roll without it, and ends at a standstill.
            var backwards = Speed + (throttle * Acceleration - Speed * Drag) * Drive.StepSeconds < 0;
            var held = backwards ? -brake : brake;
            var speed = Speed + (throttle * Acceleration - held * Braking - Speed * Drag) * Drive.StepSeconds;
            Speed = backwards ? Math.Min(0, speed) : Math.Max(0, speed);
            // Half the angle to turn by; these are the cosine and sine of an angle whose half has this tangent.
            var half = Speed * Drive.StepSeconds * steer * Curvature / 2;
            double cosine = (1 - half * half) / (1 + half * half), sine = 2 * half / (1 + half * half);
            (AheadX, AheadY) = (AheadX * cosine + AheadY * sine, AheadY * cosine - AheadX * sine);
            X += AheadX * Speed * Drive.StepSeconds;
            Y += AheadY * Speed * Drive.StepSeconds;
        }
    }
}
