// Prints what bodies do and touch, in a game whose frames are a step of physics each:
//
//     … play.dll touches       a ball falls through a gate onto a floor, and scripts are called in their order
using System;
using System.Globalization;
using UnityEngine;
using UnityPlayer;

namespace NetMQExample.PlayTest
{
    internal static class Touches
    {
        private static Rigidbody ball;

        public static int Run()
        {
            var player = new Player(typeof(NetMQLifetime).Assembly);
            player.Begin(() =>
            {
                Time.captureDeltaTime = 0.5f;
                Time.fixedDeltaTime = 0.5f;
                Physics.gravity = new Vector3(0, -8, 0);
                ball = Thing(PrimitiveType.Sphere, "ball", 10, Vector3.one).AddComponent<Rigidbody>();
                ball.gameObject.AddComponent<Touched>().enabled = false;
                var gate = Thing(PrimitiveType.Cube, "gate", 4, new Vector3(9, 4, 9));
                gate.GetComponent<Collider>().isTrigger = true;
                gate.AddComponent<Touched>();
                Thing(PrimitiveType.Cube, "floor", -13, new Vector3(9, 9, 9)).AddComponent<Touched>();
                Thing(PrimitiveType.Cube, "other", -13, new Vector3(9, 9, 9));
                var asleep = new GameObject("asleep");
                asleep.SetActive(false);
                asleep.AddComponent<Late>();
                asleep.AddComponent<Early>();
                asleep.SetActive(true);
            });
            for (var frame = 0; frame < 5; frame++)
            {
                player.Frame();
                var (height, fall) = (ball.position.y, ball.velocity.y);
                Console.WriteLine(FormattableString.Invariant($"{Time.time}: {height} {fall}"));
            }
            ball.useGravity = false;
            ball.velocity = Vector3.zero;
            ball.AddForce(new Vector3(2, 0, 0), ForceMode.Impulse);
            ball.MovePosition(new Vector3(0, 100, 0));
            player.Frame();
            Console.WriteLine(ball.position.ToString("F1", CultureInfo.InvariantCulture));
            ball.isKinematic = true;
            ball.position = new Vector3(0, -13, 0);
            player.Frame();
            player.Stop();
            Physics.gravity = new Vector3(0, -9.81f, 0);
            Console.WriteLine($"{LayerMask.NameToLayer("UI")} {LayerMask.NameToLayer("")} "
                + $"{LayerMask.NameToLayer("none")} {LayerMask.GetMask("Default", "Water", "none")} "
                + $"{LayerMask.LayerToName(2)} '{LayerMask.LayerToName(9)}'");
            return player.Errors;
        }

        private static GameObject Thing(PrimitiveType type, string name, float height, Vector3 size)
        {
            var thing = MlTest.MlSensors.Thing(type, name, new Vector3(0, height, 0));
            thing.transform.localScale = size;
            return thing;
        }

        private sealed class Touched : MonoBehaviour
        {
            private void OnTriggerEnter(Collider other) => Console.WriteLine($"{name}: {other.name} enters");
            private void OnTriggerStay(Collider other) => Console.WriteLine($"{name}: {other.name} stays");
            private void OnTriggerExit(Collider other) => Console.WriteLine($"{name}: {other.name} leaves");
            private void OnCollisionEnter(Collision collision) =>
                Console.WriteLine($"{name}: {collision.gameObject.name} hits {collision.rigidbody != null}");
            private void OnCollisionExit() => Console.WriteLine($"{name}: off");
        }

        [DefaultExecutionOrder(-1)]
        private class Early : MonoBehaviour
        {
            private bool said;

            private void Awake() => Console.WriteLine($"{GetType().Name} wakes");

            private void FixedUpdate()
            {
                if (!said) Console.WriteLine(GetType().Name);
                said = true;
            }
        }

        [DefaultExecutionOrder(1)]
        private sealed class Late : Early { }
    }
}
