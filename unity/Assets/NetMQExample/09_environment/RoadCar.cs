// Lesson 09, the second world: lesson 08's car on its road, to be driven step by step. In Python: road_car.py.
//
// It observes where it is relative to the road, or the drawn picture. Both sides give the same numbers to the last
// bit, as Car.cs and Road.cs do. Your own simulation takes its place.
using System;

namespace NetMQExample
{
    /// <summary>The reward is how many metres it came along the road; beside the road the episode ends.</summary>
    public sealed class RoadCar : PlainAgent
    {
        // So many points of the road ahead, some 9 m, it sees where the road goes.
        private const int Ahead = 60;

        private readonly Road road = new Road();
        private readonly DrawnCamera camera;
        private readonly bool seesPictures;
        private Car car;
        private double steer, pedal, metres;

        /// <summary>On the road, at its first point. What is seen is the drawn picture, or five numbers.</summary>
        public RoadCar(bool seesPictures, string name = "agent") : base(name)
        {
            this.seesPictures = seesPictures;
            car = new Car(road, 0);
            camera = new DrawnCamera(road);
            var most = new double[] { 2, 2, 2, 2, 2 };
            Observation = seesPictures
                ? GymSpace.Picture(DrawnCamera.Height, DrawnCamera.Width)
                : GymSpace.Box(Array.ConvertAll(most, each => -each), most);
        }

        /// <summary>The number of a point of the road.</summary>
        protected override int StateSize => 1;

        public override GymSpace Observation { get; }

        /// <summary>Steer, from -1, left, to 1, right; and throttle above 0, brake below.</summary>
        public override GymSpace Action { get; } = GymSpace.Box(new double[] { -1, -1 }, new double[] { 1, 1 });

        public override void OnReset()
        {
            var at = FirstState.Length > 0 ? FirstState[0] : Math.Floor(Rng.Next() * road.Points.Length);
            if (!(at >= 0 && at < road.Points.Length))
                throw new MessageException("bad-state", $"the road has the points 0 to {road.Points.Length - 1}");
            car = new Car(road, (int)at);
            (steer, pedal, metres) = (0, 0, 0);
        }

        public override void OnAction(SpaceReader action) => (steer, pedal) = (action[0], action[1]);

        public override void OnTick(double dt)
        {
            car.Step(Math.Max(0, pedal), Math.Max(0, -pedal), steer);
            var (toX, toY) = Along(road.Nearest(car.X, car.Y).At);
            var progress = (car.AheadX * toX + car.AheadY * toY) * car.Speed * dt;
            metres += progress;
            AddReward(progress);
        }

        public override void OnStepped()
        {
            Info["metres"] = metres;
            if (road.Nearest(car.X, car.Y).Distance > Road.HalfWidth) Terminate();
        }

        public override void Observe(SpaceWriter seen)
        {
            if (seesPictures)
            {
                seen.Add(Render());
                return;
            }
            var (at, _) = road.Nearest(car.X, car.Y);
            var (x, y) = road.Points[at];
            var (toX, toY) = Along(at);
            var (farX, farY) = Along(at + Ahead);
            // To the right of the road's direction is (toY, -toX).
            var off = ((car.X - x) * toY - (car.Y - y) * toX) / Road.HalfWidth;
            seen.Add(off, car.AheadX * toY - car.AheadY * toX, car.AheadX * toX + car.AheadY * toY)
                .Add(car.Speed / 20, farX * toY - farY * toX);
        }

        public override MessageArray Render()
        {
            var drawn = new byte[DrawnCamera.Size];
            var picture = new byte[DrawnCamera.Size];
            camera.Draw(drawn, car, 0);
            // Lesson 08's pictures have the lowest row first, Gymnasium's the highest.
            const int row = DrawnCamera.Width * 3;
            for (var i = 0; i < DrawnCamera.Height; i++)
                Array.Copy(drawn, i * row, picture, (DrawnCamera.Height - 1 - i) * row, row);
            return new MessageArray("uint8", picture, DrawnCamera.Height, DrawnCamera.Width, 3);
        }

        private (double X, double Y) Along(int at)
        {
            // A car that stands on the road looks along it.
            var there = new Car(road, at % road.Points.Length);
            return (there.AheadX, there.AheadY);
        }
    }
}
