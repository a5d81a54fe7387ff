// Lesson 11 in Unity, the example: a car that collects coins, and a camera above the field.
//
// Use: it stands in the lesson's scene, with a GymManager, which is CoinField, and a CameraSensor. Your own agent takes
// its place: one whose own fields have the attributes, which here are CoinCar's, because the terminal client sees with
// them too.
using System.Collections.Generic;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>CoinCar.cs in a scene, with cubes for the car and the coins.</summary>
    [AddComponentMenu("NetMQ Example/11 Coin Car Agent")]
    [RequireComponent(typeof(CameraSensor))]
    public sealed class CoinCarAgent : Agent
    {
        private readonly List<Transform> coins = new List<Transform>();
        private CoinCar car;
        private Transform body;

        protected override PlainAgent MakePlain(string name) => car = new CoinCar(name);

        public override void OnReset()
        {
            base.OnReset();
            Show();
        }

        public override object Heuristic() => new Dictionary<string, object>
        {
            ["push"] = BoxOf.Value(new[] { ArrowKeys.Horizontal, ArrowKeys.Vertical }),
            ["boost"] = ArrowKeys.Space ? 1L : 0L,
        };

        public override void OnTick(double dt)
        {
            base.OnTick(dt);
            Show();
        }

        private void Awake()
        {
            body = Cube.Make(Vector3.one, new Color32(200, 30, 30, 255));
            var eye = new GameObject("Eye").AddComponent<Camera>();
            // The whole field: half of it is 5 m, and 60 degrees from edge to edge.
            eye.transform.SetPositionAndRotation(Ground(5, 5, 8.7f), Quaternion.Euler(90, 0, 0));
            var sensor = GetComponent<CameraSensor>();
            (sensor.Camera, sensor.Width, sensor.Height) = (eye, 64, 48);
        }

        // Before the answer, so that the camera sees this moment.
        private void Show()
        {
            body.position = Ground(car.Spot.X, car.Spot.Y, 0.5f);
            while (coins.Count < car.Spots.Count)
                coins.Add(Cube.Make(Vector3.one * 0.6f, new Color32(240, 200, 40, 255)));
            for (var i = 0; i < coins.Count; i++)
            {
                // Collected coins lie below the ground.
                var (x, y) = i < car.Spots.Count ? car.Spots[i] : car.Spot;
                coins[i].position = Ground(x, y, i < car.Spots.Count ? 0.3f : -1);
            }
        }

        private static Vector3 Ground(double x, double y, float up) => new Vector3((float)x, up, (float)y);
    }
}
