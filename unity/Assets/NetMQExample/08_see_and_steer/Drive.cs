// Lesson 08, the drive: every picture has a number, and every action names the picture that it answers.
//
//     drive.Note(pictures);                            beside the pictures: their number, and what the car does
//     drive.Apply(driver.Ask(pictures.ToMessage()));   DriverClient.cs; now the action's age is known
//     drive.Step();                                    0.02 s later
//
// The car is yours: an ICar. The Python side is drive.py.
using System;
using System.Collections.Generic;

namespace NetMQExample
{
    /// <summary>A car to drive: Car.cs, or one of your own.</summary>
    public interface ICar
    {
        /// <summary>In metres a second, backwards below 0.</summary>
        double Speed { get; }

        /// <summary>Where it is, to print, such as <c>0.4 m off the middle</c>.</summary>
        string Where { get; }

        /// <summary>Adds numbers, texts, true or false by name, which Python gets beside a picture of the same moment.
        /// </summary>
        void Telemetry(IDictionary<string, object> values);

        /// <summary>Goes on for <see cref="Drive.StepSeconds"/>.</summary>
        /// <param name="throttle">-1, backwards, to 1.</param>
        /// <param name="brake">0 to 1.</param>
        /// <param name="steer">-1, left, to 1, right.</param>
        void Step(double throttle, double brake, double steer);
    }

    /// <summary>Steers a car by Python's actions or a person's. It brakes when none comes.</summary>
    public sealed class Drive
    {
        /// <summary>The seconds of one step: Unity's own Time.fixedDeltaTime.</summary>
        public const double StepSeconds = 0.02;

        // Steps without an action, after which the car brakes: half a second.
        private const int TimeoutSteps = 25;

        private readonly string run = Guid.NewGuid().ToString("N").Substring(0, 8);
        private readonly ICar car;
        private readonly Action<string> log;
        private DriveAction action = new DriveAction(0, 0, 1, 0);
        private int waited;
        private bool braking;

        /// <summary>Begins with the brake on.</summary>
        /// <param name="log">Gets the lines about the drive.</param>
        public Drive(ICar car, Action<string> log)
        {
            this.car = Require.Given("car", car);
            this.log = Require.Given("log", log);
        }

        /// <summary>One action in so many is logged; 0: none.</summary>
        public int Every { get; set; }

        /// <summary>Whether the world waits for each action, and brakes for the one that does not come.</summary>
        public bool Lockstep { get; set; }

        /// <summary>The number of steps so far, and so of a picture that is taken now.</summary>
        public long Frame { get; private set; }

        /// <summary>The world's time since the drive began.</summary>
        public TimeSpan Time => TimeSpan.FromSeconds(Frame * StepSeconds);

        /// <summary>How many actions came.</summary>
        public int Actions { get; private set; }

        /// <summary>The <c>text</c> that Python sent last beside an action; empty at first.</summary>
        public string Text { get; private set; } = "";

        /// <summary>True while a person drives. Python is still asked, but not followed: that is how a person's driving
        /// is recorded.</summary>
        public bool Manual { get; private set; }

        // The brake does not unlearn the steering: the road does not end at once.
        private DriveAction InForce => braking ? new DriveAction(action.Frame, 0, 1, action.Steer) : action;

        /// <summary>A person takes over, or goes on driving.</summary>
        public void TakeOver(double throttle, double brake, double steer)
        {
            if (!Manual) log("a person drives");
            Manual = true;
            action = new DriveAction(Frame, throttle, brake, steer);
        }

        /// <summary>The person gives back: Python's next action counts again.</summary>
        public void GiveBack()
        {
            if (Manual) log("Python drives");
            Manual = false;
        }

        /// <summary>Writes beside the pictures which moment they show.</summary>
        public void Note(CameraPictures pictures)
        {
            pictures.Frame = Frame;
            pictures.SimTime = Time.TotalSeconds;
            pictures.Run = run;
            pictures.WallTime = (DateTime.UtcNow - DateTime.UnixEpoch).TotalSeconds;
            pictures.Action = InForce;
            pictures.Speed = car.Speed;
            pictures.Manual = Manual;
            pictures.Telemetry.Clear();
            car.Telemetry(pictures.Telemetry);
        }

        /// <summary>Follows an action from the next step on.</summary>
        /// <param name="newest">Null if there was none for the last picture.</param>
        public void Apply(DriveAction? newest)
        {
            if (newest == null)
            {
                if (Lockstep) waited = TimeoutSteps;
                return;
            }
            waited = 0;
            if (!Manual) action = newest.Value;
            if (Every > 0 && Actions % Every == 0) log(Describe(newest.Value));
            Actions++;
            var text = newest.Value.Text() ?? Text;
            if (text != Text) log($"Python says {LogText.Printable(text)}");
            Text = text;
        }

        /// <summary>Drives for <see cref="StepSeconds"/>.</summary>
        public void Step()
        {
            var before = braking;
            braking = ++waited > TimeoutSteps && !Manual;
            car.Step(InForce.Throttle, InForce.Brake, InForce.Steer);
            Frame++;
            if (braking != before)
                log(braking ? "trouble: no action for 0.5 s: braking" : "an action again: driving on");
        }

        private string Describe(DriveAction newest) =>
            FormattableString.Invariant($"frame {newest.Frame}: age {Frame - newest.Frame}, ") +
            FormattableString.Invariant($"{newest.Milliseconds:F1} ms; ") +
            FormattableString.Invariant($"steer {newest.Steer:F2}, speed {car.Speed:F1} m/s, {car.Where}");
    }
}
