// Prints a camera's picture, and what is left of it:
//
//     … play.dll cameras                       on each of four graphics cards
//
// The upper half of what it looks at is red, the rest blue, and it sees one layer only.
using System;
using System.Reflection;
using UnityEngine;
using UnityPlayer;
using Object = UnityEngine.Object;

namespace NetMQExample.PlayTest
{
    internal static class Cameras
    {
        private const BindingFlags Hidden = BindingFlags.Instance | BindingFlags.NonPublic;

        public static int Run()
        {
            foreach (var noReadback in new[] { false, true })
                foreach (var topRowFirst in new[] { false, true }) Look(topRowFirst, noReadback);
            return 0;
        }

        private static void Look(bool topRowFirst, bool noReadback)
        {
            (SystemInfo.TopRowFirst, SystemInfo.NoReadback) = (topRowFirst, noReadback);
            var player = new Player(typeof(NetMQLifetime).Assembly);
            Camera camera = null;
            player.Begin(() =>
            {
                camera = new GameObject("camera").AddComponent<Camera>();
                camera.backgroundColor = new Color32(0, 0, 200, 255);
                camera.cullingMask = 1 << 5;
                var half = Cube.Make(new Vector3(40, 20, 1), new Color32(200, 0, 0, 255));
                (half.position, half.gameObject.layer) = (new Vector3(0, 10, 5), 5);
            });
            // Not square, so that rows and columns are not taken for each other.
            foreach (var grey in new[] { false, true }) Show(camera, grey);
            Console.WriteLine($"the camera draws to the screen again: {camera.targetTexture == null}");
            player.Frame();
            Console.WriteLine($"left: {string.Join(" ", Player.Left)}");
            Measure(player, camera);
            Start(player);
            Follow(player, camera);
            player.Stop();
        }

        private static void Show(Camera camera, bool grey)
        {
            using var view = new CameraView(camera, 7, 4, grey);
            // A film of the same camera.
            using var larger = new CameraView(camera, 9, 6, grey);
            var picture = view.Observe();
            camera.backgroundColor = new Color32(0, 255, 0, 255);
            // It has an array of its own.
            view.Observe();
            camera.backgroundColor = new Color32(0, 0, 200, 255);
            Console.WriteLine($"[{string.Join(", ", picture.Shape)}]: {string.Join(" ", picture.Data.ToArray())}");
        }

        // Behind and above what looks to the right, and down by 15 degrees.
        private static void Follow(Player player, Camera camera)
        {
            camera.gameObject.tag = "MainCamera";
            camera.enabled = true;
            var car = new GameObject("car").AddComponent<ChaseView>();
            car.transform.SetPositionAndRotation(new Vector3(100, 0, 7), Quaternion.Euler(0, 90, 0));
            player.Frame();
            var view = camera.transform;
            Console.WriteLine($"it follows: {view.position} {view.forward}");
        }

        private static void Measure(Player player, Camera camera)
        {
            using var view = new CameraView(camera, 64, 48, false);
            var picture = new byte[view.Size];
            var cost = new FrameCost(10);
            while (!cost.Done)
            {
                player.Frame();
                var rendering = Camera.Rendering.Elapsed;
                cost.Begin();
                view.Observe(picture);
                cost.End((Camera.Rendering.Elapsed - rendering).TotalMilliseconds);
            }
            Console.WriteLine($"cost: {cost}");
        }

        // Lesson 11's agent, whose sensor is started twice, as Unity may do it where a scene is not loaded anew.
        private static void Start(Player player)
        {
            var sensor = new GameObject("agent").AddComponent<CoinCarAgent>().GetComponent<CameraSensor>();
            player.Frame();
            Console.WriteLine($"the eye draws: {sensor.Camera.enabled}");
            typeof(CameraSensor).GetMethod("Start", Hidden).Invoke(sensor, null);
            Console.WriteLine($"sensors: {SensorComponent.All.Count}");
            Object.Destroy(sensor.gameObject);
            player.Frame();
            Console.WriteLine($"sensors: {SensorComponent.All.Count}");
        }
    }
}
