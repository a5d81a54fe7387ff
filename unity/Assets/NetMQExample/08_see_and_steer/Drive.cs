// Lesson 08, the drive: every picture has a number, and every action names the picture that it answers.
//
//     drive.Note(shot);                            beside the pictures: their number, and what the car does
//     drive.Apply(driver.Ask(shot.ToMessage(), patience, stop));          DriverClient.cs; now its age is known
//     var trouble = drive.Step();                  0.02 s later
//
// Take home: this file and DriverClient.cs; Car.cs and Road.cs stand for your own car. The Python side is drive.py.
using System;

namespace NetMQExample
{
    /// <summary>What the car is told, by whom, and what it does when nobody tells it anything.</summary>
    public sealed class Drive
    {
        // Steps without an action, after which the car brakes: half a second.
        private const int Patience = 25;

        private readonly string run = Guid.NewGuid().ToString("N").Substring(0, 8);
        private readonly Road road;
        private DriveAction action = new DriveAction(0, 0, 1, 0);
        private int waited;
        private bool braking;

        /// <summary>Begins at a point of the road, with the brake on.</summary>
        public Drive(Road road, int start = 0) => (this.road, Car) = (road, new Car(road, start % road.Points.Length));

        /// <summary>What is driven.</summary>
        public Car Car { get; }

        /// <summary>The number of steps so far, and so of a picture that is taken now.</summary>
        public long Frame { get; private set; }

        /// <summary>How many steps ago the picture was taken that the newest action answers.</summary>
        public long Age { get; private set; }

        /// <summary>True while a person drives. Python is still asked, but not followed: that is how a person's driving
        /// is recorded.</summary>
        public bool Manual { get; private set; }

        // The brake does not unlearn the steering: the road does not end at once.
        private DriveAction InForce => braking ? new DriveAction(action.Frame, 0, 1, action.Steer) : action;

        /// <summary>A person takes over, or goes on driving.</summary>
        public void TakeOver(double throttle, double brake, double steer) =>
            (Manual, action) = (true, new DriveAction(Frame, throttle, brake, steer));

        /// <summary>The person gives back: Python's next action counts again.</summary>
        public void GiveBack() => Manual = false;

        /// <summary>Writes beside a shot's pictures which moment they show.</summary>
        public void Note(Shot shot)
        {
            (shot.Frame, shot.SimTime, shot.Run) = (Frame, Frame * Car.StepSeconds, run);
            shot.WallTime = (DateTime.UtcNow - DateTime.UnixEpoch).TotalSeconds;
            (shot.Action, shot.Speed, shot.Manual) = (InForce, Car.Speed, Manual);
        }

        /// <summary>Follows an action from the next step on.</summary>
        public void Apply(DriveAction newest)
        {
            (waited, Age) = (0, Frame - newest.Frame);
            if (!Manual) action = newest;
        }

        /// <summary>Drives for <see cref="Car.StepSeconds"/>.</summary>
        /// <returns>A line about trouble that begins or ends here, or null.</returns>
        public string Step()
        {
            var before = braking;
            braking = ++waited > Patience && !Manual;
            Car.Step(InForce.Throttle, InForce.Brake, InForce.Steer);
            Frame++;
            if (braking == before) return null;
            return braking ? "trouble: no action for 0.5 s: braking" : "an action again: driving on";
        }

        /// <summary>The line to print about an action.</summary>
        public string Describe(DriveAction newest) => FormattableString.Invariant(
            $"frame {newest.Frame}: age {Age}, {newest.Milliseconds:F1} ms; steer {newest.Steer:F2}, ") +
            FormattableString.Invariant($"speed {Car.Speed:F1} m/s, {road.Nearest(Car.X, Car.Y).Distance:F1} m off the middle");
    }
}
