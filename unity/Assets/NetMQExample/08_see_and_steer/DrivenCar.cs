// Lesson 08 in Unity: the car, which Drive.cs moves in each FixedUpdate, and whose cameras are real ones.
//
// Use: it stands in the lesson's scene beside CameraSender. At home your own car takes its place: what CameraSender
// needs of it are Drive, Step and AddCamera.
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

        /// <summary>One step of the world, in lock-step by whoever waits for it.</summary>
        public void Step()
        {
            Drive.Step();
            Place();
        }

        /// <summary>A camera above the bonnet that renders when it is asked to.</summary>
        /// <param name="right">Metres to the right of the middle.</param>
        public Camera AddCamera(double right)
        {
            var eye = new GameObject("Camera").AddComponent<Camera>();
            eye.transform.SetParent(transform, false);
            eye.transform.localPosition = new Vector3((float)right, 1.5f, 0);
            eye.transform.localRotation = Quaternion.Euler(16.26f, 0, 0);
            (eye.enabled, eye.fieldOfView, eye.clearFlags) = (false, 60, CameraClearFlags.SolidColor);
            eye.backgroundColor = new Color32(150, 190, 230, 255);
            eye.targetTexture = CameraReadback.Texture(DrawnCamera.Width, DrawnCamera.Height);
            return eye;
        }

        private void Awake()
        {
            Drive = new Drive(new Road(), start, Debug.Log);
            Part(new Vector3(0, 0.45f, -1), new Vector3(1.6f, 0.5f, 3));
            Part(new Vector3(0, 0.9f, -1.5f), new Vector3(1.4f, 0.5f, 1.6f));
            Place();
            if (Math.Abs(Time.fixedDeltaTime - Car.StepSeconds) > 1e-6)
                Debug.LogWarning("trouble: the car's clock goes wrong: set Edit, Project Settings, Time, Fixed Timestep to 0.02");
        }

        private void FixedUpdate()
        {
            if (!Drive.Lockstep) Step();
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
