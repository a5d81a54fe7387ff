// Lesson 08 in Unity: the car, which Drive.cs moves in each FixedUpdate.
//
// Use: it stands in the lesson's scene beside CameraSender. At home your own car takes its place: what CameraSender
// needs of it are Drive and Follow.
using System;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Stands where the drive's car is: its x and y are Unity's x and z.</summary>
    public sealed class DrivenCar : MonoBehaviour
    {
        [SerializeField, Min(0), Tooltip("The point of the road to begin at")] private int start;

        /// <summary>What is driven, by Python or by <see cref="Drive.TakeOver"/>.</summary>
        public Drive Drive { get; private set; }

        /// <summary>Does what Python says; in lock-step for one step, in which the world waited for it.</summary>
        /// <param name="action">Null if nothing came.</param>
        public void Follow(DriveAction? action)
        {
            Drive.Apply(action);
            if (Drive.Lockstep) Step();
        }

        private void Awake()
        {
            Drive = new Drive(new Road(), start, Debug.Log);
            Part(new Vector3(0, 0.45f, -1), new Vector3(1.6f, 0.5f, 3));
            Part(new Vector3(0, 0.9f, -1.5f), new Vector3(1.4f, 0.5f, 1.6f));
            Place();
            if (Math.Abs(Time.fixedDeltaTime - Car.StepSeconds) > 1e-6)
                Debug.LogWarning("trouble: time goes wrong: set Project Settings, Time, Fixed Timestep to 0.02");
        }

        private void FixedUpdate()
        {
            if (!Drive.Lockstep) Step();
        }

        private void Step()
        {
            Drive.Step();
            Place();
        }

        private void Place()
        {
            var ahead = new Vector3((float)Drive.Car.AheadX, 0, (float)Drive.Car.AheadY);
            transform.SetPositionAndRotation(
                new Vector3((float)Drive.Car.X, 0, (float)Drive.Car.Y), Quaternion.LookRotation(ahead));
        }

        // All behind the cameras and below: they do not see it.
        private void Part(Vector3 middle, Vector3 size)
        {
            var cube = GameObject.CreatePrimitive(PrimitiveType.Cube);
            cube.transform.SetParent(transform, false);
            (cube.transform.localPosition, cube.transform.localScale) = (middle, size);
        }
    }
}
