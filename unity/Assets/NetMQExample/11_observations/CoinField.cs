// Lesson 11 in Unity, the example's field. Your own scene has a GymManager in its place.
using UnityEngine;

namespace NetMQExample
{
    /// <summary>The GymManager of a scene with coins.</summary>
    [AddComponentMenu("NetMQ Example/11 Coin Field")]
    public sealed class CoinField : GymManager
    {
        private void Awake()
        {
            (EnvName, Dt) = ("Coins", 0.1);
            var ground = Cube.Make(Vector3.one * (float)CoinCar.Field, new Color32(40, 80, 40, 255));
            ground.position = new Vector3(5, -5, 5);
        }
    }
}
