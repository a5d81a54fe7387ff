// Measures what a picture costs lesson 08's network thread:
//
//     … play.dll pictures tcp://127.0.0.1:5558        100 pictures, after 100 that do not count
using System;
using System.Threading;
using UnityEngine;
using UnityPlayer;

namespace NetMQExample.PlayTest
{
    /// <summary>Measures from taking the newest picture to having its action.</summary>
    public sealed class MeasuredSender : NetworkBehaviour
    {
        private readonly FrameCost cost = new FrameCost(100);
        private PictureTaker taker;
        private DriveAction? newest;

        public DrivenBehaviour Car { get; set; }
        public string Endpoint { get; set; }

        protected override void Talk(CancellationToken stop)
        {
            using var driver = new DriverClient(Endpoint, TimeSpan.FromSeconds(60));
            FromUpdate(() => taker = new PictureTaker("center", false, 1, Car.CameraFor));
            while (!cost.Done)
            {
                cost.Begin();
                newest = driver.Ask(taker.Next(stop), stop);
                cost.End();
            }
            Log($"cost: {cost}; steer {newest.Value.Steer}");
        }

        protected override void Update()
        {
            base.Update();
            if (!Done) taker?.Poll(Car.Drive, false);
        }
    }

    internal static class PictureCost
    {
        public static int Run(string endpoint)
        {
            var player = new Player(typeof(NetMQLifetime).Assembly);
            MeasuredSender sender = null;
            player.Begin(() =>
            {
                var thing = new GameObject("car");
                thing.SetActive(false);
                Scripts.AddTo(thing, Scripts.Of(typeof(NetMQLifetime).Assembly, "8"));
                thing.GetComponent<CameraSender>().enabled = false;
                sender = thing.AddComponent<MeasuredSender>();
                (sender.Car, sender.Endpoint) = (thing.GetComponent<DrivenCar>(), endpoint);
                thing.SetActive(true);
            });
            player.Run(TimeSpan.FromMinutes(1), () => sender.Done);
            player.Stop();
            return player.Errors > 0 ? 1 : 0;
        }
    }
}
