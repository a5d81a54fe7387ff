// Lesson 08 in Unity: the lesson's car, a point on a road in the shape of two cubes.
//
// Use: it stands in the lesson's scene beside CameraSender. A car of your own can take its place; see
// DrivenBehaviour.cs.
using System;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Stands where the world's car is: its x and y are Unity's x and z.</summary>
    [AddComponentMenu("NetMQ Example/08 Driven Car")]
    public sealed class DrivenCar : DrivenBehaviour
    {
        [SerializeField, Min(0), Tooltip("The point of the road to begin at")] private int start;

        /// <summary>What is moved.</summary>
        public Car Car { get; private set; }

        public override double Speed => Car.Speed;
        public override string Where => Car.Where;

        public override void Step(double throttle, double brake, double steer)
        {
            Car.Step(throttle, brake, steer);
            Place();
        }

        private void Awake()
        {
            Car = new Car(new Road(), start);
            // All behind the cameras and below: they do not see it.
            Cube.Make(new Vector3(1.6f, 0.5f, 3), parent: transform).localPosition = new Vector3(0, 0.45f, -1);
            Cube.Make(new Vector3(1.4f, 0.5f, 1.6f), parent: transform).localPosition = new Vector3(0, 0.9f, -1.5f);
            Place();
            if (Math.Abs(Time.fixedDeltaTime - Drive.StepSeconds) > 1e-6)
                Debug.LogWarning("trouble: time goes wrong: set Project Settings, Time, Fixed Timestep to 0.02");
        }

        private void Place()
        {
            var ahead = new Vector3((float)Car.AheadX, 0, (float)Car.AheadY);
            var place = new Vector3((float)Car.X, 0, (float)Car.Y);
            transform.SetPositionAndRotation(place, Quaternion.LookRotation(ahead));
        }
    }
}
