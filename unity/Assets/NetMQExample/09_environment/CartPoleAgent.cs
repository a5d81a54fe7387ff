// Lesson 09 in Unity, the example: a pole on a cart, which Python balances. In GymManager tick By Hand, and the arrow
// keys do.
//
// Use: start python/09_environment/server.py, open this lesson's scene, press Play. Of several, each on an object of
// its own, Python makes a vector (lesson 10).
using System;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>CartPole.cs in a scene, with a cart and a pole made of cubes.</summary>
    [AddComponentMenu("NetMQ Example/09 Cart Pole Agent")]
    public sealed class CartPoleAgent : Agent
    {
        private CartPole world;
        private Transform cart, pole;

        protected override PlainAgent MakePlain(string name) => world = new CartPole(name);

        public override object Heuristic() =>
            // There is no third way: whoever does not push to the right pushes to the left.
            ArrowKeys.Horizontal > 0 ? 1L : 0L;

        private void Awake()
        {
            cart = Cube.Make(new Vector3(0.8f, 0.5f, 0.5f), null, transform);
            pole = Cube.Make(new Vector3(0.1f, 2, 0.1f), null, transform);
            Cube.Make(new Vector3(5, 0.05f, 0.1f), null, transform);
        }

        private void LateUpdate()
        {
            cart.localPosition = new Vector3((float)world.Place, 0, 0);
            var along = new Vector3((float)Math.Sin(world.Angle), (float)Math.Cos(world.Angle), 0);
            pole.localPosition = cart.localPosition + along;
            pole.localRotation = Quaternion.Euler(0, 0, (float)(-world.Angle * 180 / Math.PI));
        }
    }
}
