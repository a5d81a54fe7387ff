// Lesson 10 in Unity, the example: hunters and rabbits as cubes. Tick By Hand, and the arrow keys drive hunter_0.
//
// Use: start python/10_many_agents/server.py, add this component to any GameObject, press Play.
using System.Collections.Generic;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Pursuit.cs in a scene: the world, which makes the agents.</summary>
    [AddComponentMenu("NetMQ Example/10 Pursuit Game")]
    public sealed class PursuitGame : GymManager
    {
        private readonly Pursuit world = new Pursuit();

        public override void OnReset(RandomGenerator random, IReadOnlyDictionary<string, object> options) =>
            world.OnReset(random, options);

        public override void OnTick(double dt) => world.OnTick(dt);
        public override MessageArray Render() => world.Render();

        private void Awake()
        {
            (EnvName, Dt) = ("Pursuit", 0.1);
            world.SendInfo = SendInfo;
            foreach (var player in world.Players)
            {
                var animal = new GameObject(player.Name);
                // It wakes up when it has its player.
                animal.SetActive(false);
                animal.AddComponent<Animal>().Player = player;
                animal.SetActive(true);
                // Hunters are the taller ones.
                Cube.Make(new Vector3(0.3f, player.Hunts ? 0.6f : 0.3f, 0.3f), null, animal.transform);
            }
        }

        private sealed class Animal : Agent
        {
            public PursuitPlayer Player { get; set; }

            protected override PlainAgent MakePlain(string name) => Player;

            public override object Heuristic()
            {
                var (x, y) = (ArrowKeys.Horizontal, ArrowKeys.Vertical);
                // The others rest: alone one wins slowly.
                if (Player.Name != "hunter_0" || (x == 0 && y == 0)) return 0L;
                return x != 0 ? x < 0 ? 1L : 2L : y < 0 ? 3L : 4L;
            }

            // One that is out is higher than the camera, which looks down. The world is 8 m wide.
            private void LateUpdate() => transform.position =
                new Vector3((float)(4 * Player.X), Player.Lives ? 0 : 20, (float)(4 * Player.Y));
        }
    }
}
