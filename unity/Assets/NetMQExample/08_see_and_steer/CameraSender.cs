// Lesson 08 in Unity: every picture has a number, and every action names the picture that it answers.
//
// Use: start python/08_see_and_steer/server.py, open this lesson's scene, press Play. Arrow keys take over, Enter gives
// back. For your own scene: DrivenBehaviour.cs says how a car of yours stands beside it.
// The cameras render when this asks them to, so a picture and what is written beside it show the same moment. The
// picture arrives a frame or two later, and is sent by a thread of its own: no frame waits for the network, nor, but in
// lock-step, for the graphics card.
using System.Threading;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Sends what the cameras see, and has the car do what Python says.</summary>
    [AddComponentMenu("NetMQ Example/08 Camera Sender")]
    public sealed class CameraSender : NetworkBehaviour
    {
        [SerializeField, Tooltip("The driver, or beacon://NAME:5558")] private string endpoint = "tcp://127.0.0.1:5558";
        [SerializeField, Min(0), Tooltip("End after so many actions")] private int count = 500;
        [SerializeField, Min(0), Tooltip("Log one action in so many; 0: none")] private int every = 50;
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait for each action")] private float timeout = 1;
        [SerializeField, Min(1), Tooltip("Pictures in a row that may stay without an action")] private int tries = 5;
        [SerializeField, Tooltip("center; left,right; or left,center,right")] private string cameras = "center";
        [SerializeField, Tooltip("The world waits for each action")] private bool lockstep;
        [SerializeField, Tooltip("Send JPEG instead of raw bytes")] private bool jpeg;
        [SerializeField, Tooltip("What Python says, to be read here")] private string text = "";

        private DrivenBehaviour car;
        private PictureTaker taker;

        private void Start()
        {
            car = GetComponent<DrivenBehaviour>();
            if (car == null)
            {
                Debug.LogError("gave up: no car beside CameraSender; add DrivenCar, or one of your own");
                enabled = false;
                return;
            }
            car.Drive.Every = every;
            car.Drive.Lockstep = lockstep;
        }

        protected override void Talk(CancellationToken stop)
        {
            Log($"asking {endpoint}");
            using var driver = new DriverClient(endpoint, Seconds(timeout), tries, Log);
            PictureTaker mine = null;
            // On the main thread, which cancels: what is on its way then is lost before the component is enabled again.
            stop.Register(() => { mine?.Dispose(); if (taker == mine) taker = null; });
            FromUpdate(() => taker = mine = stop.IsCancellationRequested ? null
                : new PictureTaker(cameras, jpeg, lockstep ? 1 : car.Steps, car.CameraFor));
            for (var answered = 0; answered < count;)
            {
                var action = driver.Ask(taker.Next(stop), stop);
                if (action != null) answered++;
                InUpdate(() => { car.Follow(action); text = car.Drive.Text; });
            }
            Log($"done: {count} actions, {taker.Skipped} pictures skipped");
        }

        protected override void Update()
        {
            base.Update();
            // After an end by trouble nobody needs pictures.
            if (!Done) taker?.Poll(car.Drive, lockstep);
        }
    }
}
