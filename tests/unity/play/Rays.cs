// Prints what lesson 11's rays meet, a line for each view:
//
//     … play.dll rays          a wall ahead at 3 m, a coin to the right at 2 m, and a car that looks and turns
using System;
using System.Globalization;
using System.Linq;
using UnityEngine;
using UnityPlayer;

namespace NetMQExample.PlayTest
{
    internal static class Rays
    {
        public static int Run()
        {
            var player = new Player(typeof(NetMQLifetime).Assembly);
            player.Begin(Look);
            player.Stop();
            return player.Errors > 0 ? 1 : 0;
        }

        private static void Look()
        {
            var wall = Thing(PrimitiveType.Cube, "wall", new Vector3(0, 0, 3.5f));
            wall.transform.localScale = new Vector3(20, 1, 1);
            Thing(PrimitiveType.Sphere, "coin", new Vector3(2.5f, 0, 0)).layer = 3;
            var car = new GameObject("car").transform;
            Show("thin", car, 0, -5);
            Show("thick", car, 0.5f, -5);
            Show("without layer 3", car, 0, ~(1 << 3));
            car.rotation = Quaternion.Euler(0, 90, 0);
            Show("turned", car, 0, -5);
            // Its own collider is around the place where rays begin.
            car.rotation = Quaternion.identity;
            car.gameObject.AddComponent<BoxCollider>();
            car.localScale = new Vector3(0.25f, 0.25f, 0.25f);
            Show("small", car, 0, -5);
        }

        internal static GameObject Thing(PrimitiveType type, string tag, Vector3 place)
        {
            var thing = GameObject.CreatePrimitive(type);
            thing.name = thing.tag = tag;
            thing.transform.position = place;
            return thing;
        }

        // One ray ahead, one to each side, 90 degrees from it, each 4 m long.
        private static void Show(string what, Transform car, float radius, int layers)
        {
            var seen = new float[12];
            new RayView(car, 1, 90, 4, radius, layers, "wall", "coin").Observe(seen);
            Console.WriteLine(
                $"{what}: {string.Join(" ", seen.Select(one => one.ToString("0.###", CultureInfo.InvariantCulture)))}");
        }
    }
}
