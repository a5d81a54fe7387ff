// Lesson 08 in Unity: a car of your own.
//
// Derive from it, put it beside CameraSender, and drag a camera of yours into Eye, or leave it empty:
//     public sealed class MyCar : DrivenBehaviour
//     {
//         public override double Speed => Vector3.Dot(body.velocity, transform.forward);      Unity 6: linearVelocity
//         public override void Step(double throttle, double brake, double steer) => … forces, wheels, …
//     }
using System;
using System.Collections.Generic;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>The car that CameraSender shows to Python, and steers.</summary>
    public abstract class DrivenBehaviour : MonoBehaviour, ICar
    {
        [SerializeField, Tooltip("A camera whose view Python gets; none: one on the car")] private Camera eye;
        [SerializeField, Min(1), Tooltip("Pixels of a picture")] private int width = DrawnCamera.Width;
        [SerializeField, Min(1), Tooltip("Pixels of a picture")] private int height = DrawnCamera.Height;
        [SerializeField, Min(1), Tooltip("A picture for each so many steps of 0.02 s")] private int steps = 1;
        [SerializeField, Tooltip("With each picture's action")] private Arrival<DriveAction> acted = new();
        private Drive drive;

        public event Action<DriveAction> Acted { add => acted.Raised += value; remove => acted.Raised -= value; }

        /// <summary>The camera whose view Python gets, or null for one on the car. Set it before CameraSender is
        /// enabled.</summary>
        public Camera Eye { get => eye; set => eye = value; }

        /// <summary>For each so many of the world's steps there is a picture; in lock-step, for each one.</summary>
        public int Steps => steps;

        /// <summary>What is driven, with the brake on at first, by Python or by <see cref="Drive.TakeOver"/>.</summary>
        public Drive Drive => drive ??= new Drive(this, Debug.Log);

        public abstract double Speed { get; }
        public virtual string Where => $"at {transform.position}";
        public abstract void Step(double throttle, double brake, double steer);

        /// <summary>Adds values of your own, which Python gets beside each picture of the same moment:
        /// <c>values["battery"] = battery;</c>. They are numbers, texts, true or false.</summary>
        public virtual void Telemetry(IDictionary<string, object> values)
        {
        }

        /// <summary>Gets each picture's action, with values of your own: <c>action.Value("zoom", 1)</c>.</summary>
        protected virtual void OnAction(DriveAction action)
        {
        }

        /// <summary>Makes a camera for PictureTaker.cs.</summary>
        /// <param name="right">Metres to the right of the middle.</param>
        public Camera CameraFor(double right) =>
            eye == null ? CarCamera.On(transform, right, width, height) : CarCamera.Beside(eye, right, width, height);

        /// <summary>Does what Python says; in lock-step for one step, in which the world waited for it.</summary>
        /// <param name="action">Null if nothing came.</param>
        public void Follow(DriveAction? action)
        {
            Drive.Apply(action);
            if (action != null) OnAction(action.Value);
            if (Drive.Lockstep) Drive.Step();
            if (action != null) acted.Raise(action.Value);
        }

        /// <summary>Drives on. Virtual, so that the compiler warns of a FixedUpdate in a class of yours, which Unity
        /// would call in its place.</summary>
        protected virtual void FixedUpdate()
        {
            if (!Drive.Lockstep) Drive.Step();
        }
    }
}
