// Lesson 17 in Unity: a scene of the fleet. It comes to the hub, and steps for whichever trainer the hub has for it.
//
// Use: start python/17_many_machines/server.py, add this component to any GameObject, press Play; then start train.py.
// Your own world takes the place of lesson 09's pole on a cart.
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Lesson 09's cart and pole, as a simulator of a hub.</summary>
    [AddComponentMenu("NetMQ Example/17 Fleet Member")]
    public sealed class FleetMember : SteppedBehaviour
    {
        [SerializeField, Tooltip("The hub, or beacon://NAME:5567")] private string endpoint = "tcp://127.0.0.1:5567";
        [SerializeField, Tooltip("What the hub must expect")] private string build = "1";

        private readonly CartPole world = new CartPole();
        private Transform cart;

        protected override string Endpoint => endpoint;

        protected override SimulatorBase MakeSimulator() =>
            new FleetSimulator(new SceneSimulator("CartPole", 0.02, new[] { world }), build);

        private void Awake() => cart = Cube.Make(Vector3.one);

        // On its place of the track, and turned as the pole is.
        private void LateUpdate()
        {
            var turn = Quaternion.Euler(0, 0, (float)(-world.Angle * 180 / System.Math.PI));
            cart.SetPositionAndRotation(new Vector3((float)world.Place, 0, 0), turn);
        }
    }
}
