// One short Play that prints what happens to a script, in the order in which it happens.
using System;
using System.Threading;
using System.Threading.Tasks;
using UnityEngine;
using UnityPlayer;

namespace NetMQExample.PlayTest
{
    public sealed class Events : MonoBehaviour
    {
        private readonly Thread main = Thread.CurrentThread;
        private bool silent;

        public static void Print()
        {
            var player = new Player(typeof(Events).Assembly);
            GameObject first = null;
            player.Begin(() =>
            {
                first = new GameObject("first");
                first.AddComponent<Events>();
            });
            player.Frame();
            first.GetComponent<Events>().silent = true;
            var doomed = new GameObject("doomed");
            var script = doomed.AddComponent<Doomed>();
            var token = script.destroyCancellationToken;
            Destroy(doomed);
            Console.WriteLine($"destroyed is null: {script == null}");
            player.Frame();
            Console.WriteLine($"destroyed is null: {script == null}, and its token cancelled: {token.IsCancellationRequested}");
            first.GetComponent<Events>().silent = false;
            Application.quitting += Quitting;
            player.Stop();
            Application.quitting -= Quitting;
        }

        [RuntimeInitializeOnLoadMethod(RuntimeInitializeLoadType.SubsystemRegistration)]
        private static void First() => Console.WriteLine("SubsystemRegistration");

        [RuntimeInitializeOnLoadMethod(RuntimeInitializeLoadType.AfterAssembliesLoaded)]
        private static void Second() => Console.WriteLine("AfterAssembliesLoaded");

        [RuntimeInitializeOnLoadMethod(RuntimeInitializeLoadType.BeforeSplashScreen)]
        private static void Third() => Console.WriteLine("BeforeSplashScreen");

        [RuntimeInitializeOnLoadMethod(RuntimeInitializeLoadType.BeforeSceneLoad)]
        private static void Fourth() => Console.WriteLine("BeforeSceneLoad");

        [RuntimeInitializeOnLoadMethod]
        private static void Last() => Console.WriteLine("AfterSceneLoad");

        private static void Quitting() => Console.WriteLine("quitting");

        private void Awake() => Say("Awake");

        private void OnEnable() => Say("OnEnable");

        private void Start() => Say($"Start in frame {Time.frameCount}");

        private void FixedUpdate() => Say("FixedUpdate");

        private async void Update()
        {
            if (silent) return;
            Say("Update");
            // A continuation that is ready at once, but must not run before the others had their Update.
            await Task.Yield();
            Say($"after await, on the main thread: {Thread.CurrentThread == main}");
        }

        private void LateUpdate()
        {
            if (silent) return;
            Say("LateUpdate");
            var other = new Thread(() =>
            {
                try
                {
                    Say($"{Time.time}");
                }
                catch (UnityException e)
                {
                    Say($"off the main thread: {e.Message.Split('\n')[0]}");
                }
            });
            other.Start();
            other.Join();
        }

        private void OnApplicationQuit() => Say("OnApplicationQuit");

        private void OnDisable() => Say("OnDisable");

        private void OnDestroy() => Say("OnDestroy");

        private void Say(string what)
        {
            if (!silent) Console.WriteLine(what);
        }
    }

    public sealed class Doomed : MonoBehaviour
    {
        private void OnDisable() => Console.WriteLine("Destroy: OnDisable");

        private void OnDestroy() => Console.WriteLine("Destroy: OnDestroy");
    }
}
