// Scripts do what scripts do in Unity, and this prints how the player took it: one Play for the order of events, and
// one for the rest.
using System;
using System.Collections;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using UnityEngine;
using UnityPlayer;
using Object = UnityEngine.Object;

namespace NetMQExample.PlayTest
{
    internal static class Habits
    {
        private static readonly string[] Urp = { "Sprites/Default", "Universal Render Pipeline/Lit" };

        public static int Print()
        {
            Events();
            var player = new Player(typeof(NetMQLifetime).Assembly);
            player.Begin(() =>
            {
                ShowLines();
                DrawShapes();
                RunInBackground();
            });
            player.Stop();
            Application.runInBackground = true;
            return 0;
        }

        private static void Events()
        {
            var player = new Player(typeof(Habits).Assembly);
            player.Begin(() => new GameObject("first").AddComponent<Ordered>());
            player.Frame();
            // After a long frame several FixedUpdates come in the next one, which has to make up for it, but not for
            // all of it.
            Thread.Sleep(500);
            player.Frame();
            player.Stop();
        }

        private static void ShowLines()
        {
            var text = new GameObject("text");
            text.AddComponent<LastLine>();
            foreach (var line in new[] { "a line",
                $"{new string('a', 59)} b {new string('c', 70)} d\n{new string('e', 60)} f" })
            {
                Debug.Log(line);
                Console.WriteLine($"shown: {text.GetComponent<TextMesh>().text.Replace("\n", "|")}");
            }
        }

        // In URP's editor a shape is Unity's own; in its builds it must not be.
        private static void DrawShapes()
        {
            var moved = new GameObject("moved");
            moved.AddComponent<Cube>();
            moved.transform.position = Vector3.up;
            var parts = moved.transform.GetComponentsInChildren<Renderer>();
            Console.WriteLine($"a cube: {string.Join(" ", parts.Select(part => part.transform.position))}");
            foreach (var shaders in new[] { null, Urp.Take(1).ToArray(), Urp })
            {
                foreach (var editor in new[] { true, false })
                {
                    (Player.UrpShaders, Application.Editor) = (shaders, editor);
                    var colour = new Color32((byte)(shaders?.Length ?? 0), editor ? (byte)1 : (byte)0, 0, 255);
                    var shape = Cube.Make(Vector3.one, colour);
                    Console.WriteLine($"drawn by: {shape.GetComponent<Renderer>().sharedMaterial.Drawn}");
                }
            }
            (Player.UrpShaders, Application.Editor) = (null, false);
        }

        // The setting of the whole game is left alone, or set, and said once.
        private static void RunInBackground()
        {
            Application.runInBackground = false;
            foreach (var wanted in new[] { false, true, true })
            {
                var web = new GameObject("web");
                web.SetActive(false);
                Inspector.Set(new MonoBehaviour[] { web.AddComponent<HelloWeb>() }, "runInBackground", $"{wanted}");
                web.SetActive(true);
                Console.WriteLine($"HelloWeb: {Application.runInBackground}");
                Object.DestroyImmediate(web);
            }
        }
    }

    public sealed class Ordered : MonoBehaviour
    {
        private readonly Thread main = Thread.CurrentThread;
        private GameObject doomed;

        private void Awake() => Say("Awake");
        private void OnEnable() => Say("OnEnable");

        private void Start()
        {
            Say($"Start in frame {Time.frameCount}");
            doomed = new GameObject("doomed");
            doomed.AddComponent<Refused>();
            Destroy(doomed);
        }

        private void FixedUpdate() => Say(Time.deltaTime == Time.fixedDeltaTime ? "FixedUpdate" : "a wrong deltaTime");

        private async void Update()
        {
            var capped = Time.deltaTime <= Time.maximumDeltaTime && Time.deltaTime <= Time.unscaledDeltaTime;
            Say($"Update, deltaTime is capped: {capped}");
            // A continuation that is ready at once, but must not run before the others had their Update.
            await Task.Yield();
            Say($"after await, on the main thread: {Thread.CurrentThread == main}");
        }

        private void LateUpdate()
        {
            Say($"LateUpdate, destroyed is null: {doomed == null}");
            var other = new Thread(() =>
            {
                try { Say($"{Time.time}"); }
                catch (UnityException e) { Say($"off the main thread: {e.Message.Split('\n')[0]}"); }
            });
            other.Start();
            other.Join();
        }

        private void OnApplicationPause(bool paused) => Say($"OnApplicationPause {paused}");
        private void OnApplicationQuit() => Say("OnApplicationQuit");
        private void OnDisable() => Say("OnDisable");
        private void OnDestroy() => Say("OnDestroy");
        private static void Say(string what) => Console.WriteLine(what);
    }

    public sealed class Refused : MonoBehaviour
    {
        private IEnumerator OnEnable()
        {
            yield return null;
        }

        private void Update() => throw new InvalidOperationException("in Update");
    }
}
