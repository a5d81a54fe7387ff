// One Play in which scripts do what scripts do in Unity, and this prints how the player took it.
using System;
using System.Collections;
using System.Threading;
using System.Threading.Tasks;
using UnityEngine;
using UnityPlayer;

namespace NetMQExample.PlayTest
{
    public sealed class Habits : MonoBehaviour
    {
        private static volatile bool sent, slow;
        private int frames;

        public static void Print()
        {
            Application.runInBackground = false;
            var player = new Player(typeof(Habits).Assembly);
            player.Begin(() =>
            {
                var thing = new GameObject("first");
                var habits = thing.AddComponent<Habits>();
                thing.name = "renamed";
                Console.WriteLine($"a component's name: {habits.name}");
                var text = new GameObject("text");
                text.AddComponent<LastLine>();
                Debug.Log("a line");
                Console.WriteLine($"shown: {text.GetComponent<TextMesh>().text}");
                thing.AddComponent<Once>();
                // Both want to go on in the background; it is said once.
                new GameObject("client 1").AddComponent<HelloClient>();
                new GameObject("client 2").AddComponent<HelloClient>();
                Console.WriteLine($"a second one: {thing.AddComponent<Once>() == null}");
            });
            for (var i = 0; i < 3 || !sent; i++)
            {
                player.Frame();
                Thread.Sleep(5);
            }
            slow = true;
            // A long frame: the next one has to make up for it, but not for all of it.
            Thread.Sleep(1000);
            player.Frame();
            player.Stop();
            Application.runInBackground = true;
        }

        private IEnumerator Start()
        {
            yield return null;
        }

        private void OnValidate() => Console.WriteLine("OnValidate");

        private void OnApplicationPause(bool paused) => Console.WriteLine($"OnApplicationPause {paused}");

        private void OnApplicationFocus(bool focus) => Console.WriteLine($"OnApplicationFocus {focus}");

        private void FixedUpdate()
        {
            if (Time.deltaTime != Time.fixedDeltaTime) Console.WriteLine("a wrong deltaTime in FixedUpdate");
        }

        private async void Update()
        {
            if (++frames == 1) new GameObject("made in Update").AddComponent<Late>();
            if (slow) Console.WriteLine($"deltaTime is capped: {Time.deltaTime <= Time.maximumDeltaTime}, unscaledDeltaTime: {Time.unscaledDeltaTime <= Time.maximumDeltaTime}");
            if (frames != 2) return;
            var context = SynchronizationContext.Current;
            var main = Thread.CurrentThread;
            var other = Task.Run(() =>
            {
                var where = false;
                context.Send(_ => where = Thread.CurrentThread == main, null);
                return where;
            });
            await Task.Yield();
            Console.WriteLine("after await");
            Console.WriteLine($"Send came to the main thread: {await other}");
            sent = true;
            throw new InvalidOperationException("in a continuation");
        }

        private void OnGUI()
        {
            if (frames == 1) Console.WriteLine("OnGUI");
        }
    }

    public sealed class Late : MonoBehaviour
    {
        private bool said;

        private void Start() => Console.WriteLine($"Start of what was made in frame {Time.frameCount}");

        private void LateUpdate()
        {
            if (!said) Console.WriteLine($"LateUpdate of what was made in frame {Time.frameCount}");
            said = true;
        }
    }

    [DisallowMultipleComponent]
    public sealed class Once : MonoBehaviour
    {
    }
}
