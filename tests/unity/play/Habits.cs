// One Play in which scripts do what scripts do in Unity, and this prints how the player took it.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Linq;
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
            HelloBackground hello = null;
            player.Begin(() =>
            {
                var thing = new GameObject("first");
                var habits = thing.AddComponent<Habits>();
                thing.name = "renamed";
                Console.WriteLine($"a component's name: {habits.name}");
                var text = new GameObject("text");
                text.AddComponent<LastLine>();
                foreach (var line in new[] { "a line", $"{new string('a', 59)} b {new string('c', 70)} d\n{new string('e', 60)} f" })
                {
                    Debug.Log(line);
                    Console.WriteLine($"shown: {text.GetComponent<TextMesh>().text.Replace("\n", "|")}");
                }
                var moved = new GameObject("moved");
                moved.AddComponent<Cube>();
                moved.transform.position = Vector3.up;
                Console.WriteLine($"a cube: {string.Join(" ", moved.transform.GetComponentsInChildren<Renderer>().Select(part => part.transform.position))}");
                // In URP's editor a shape is Unity's own; in its builds it must not be.
                foreach (var shaders in new[] { null, new[] { "Sprites/Default" }, new[] { "Sprites/Default", "Universal Render Pipeline/Lit" } })
                {
                    foreach (var editor in new[] { true, false })
                    {
                        (Player.UrpShaders, Player.Editor) = (shaders, editor);
                        var shape = Cube.Make(Vector3.one, new Color32((byte)(shaders?.Length ?? 0), editor ? (byte)1 : (byte)0, 0, 255));
                        Console.WriteLine($"drawn by: {Player.ShaderOf(shape.GetComponent<Renderer>())}");
                    }
                }
                (Player.UrpShaders, Player.Editor) = (null, false);
                // The setting of the whole game is left alone, or set and said.
                foreach (var wanted in new[] { false, true })
                {
                    Application.runInBackground = false;
                    var web = new GameObject("web");
                    web.SetActive(false);
                    Inspector.Set(new MonoBehaviour[] { web.AddComponent<HelloWeb>() }, "runInBackground", $"{wanted}");
                    web.SetActive(true);
                    Console.WriteLine($"HelloWeb: {Application.runInBackground}");
                    DestroyImmediate(web);
                }
                Application.runInBackground = false;
                thing.AddComponent<Once>();
                // Both want to go on in the background; it is said once.
                new GameObject("client 1").AddComponent<HelloClient>();
                new GameObject("client 2").AddComponent<HelloClient>();
                Console.WriteLine($"a second one: {thing.AddComponent<Once>() == null}");
                // It counts frames until its client is done, and this one is done when it is switched off.
                var counted = new GameObject("counted");
                counted.SetActive(false);
                hello = counted.AddComponent<HelloBackground>();
                Inspector.Set(new MonoBehaviour[] { hello }, "endpoint", "tcp://127.0.0.1:9");
                Inspector.Set(new MonoBehaviour[] { hello }, "timeout", "60");
                // A headset shows no OnGUI.
                counted.AddComponent<TextMesh>();
                counted.AddComponent<HelloWorldHud>();
                counted.SetActive(true);
                // What a class is made of comes back; what Unity's serializer passes over does not.
                var written = JsonUtility.ToJson(new Order { hp = 3, path = { Vector3.up }, text = "a \"word\",\n" });
                var read = JsonUtility.FromJson<Order>(written.Replace("3", "-4").Replace("0.5", "2.5e-1"));
                Console.WriteLine($"JSON: {written} {read.hp} {read.speeds[1]} {read.path[0]} {read.to.who} {read.text.Length} {read.Unseen}");
                var said = new UnityEngine.Events.UnityEvent<string>();
                UnityEngine.Events.UnityAction<string> hear = word => Console.WriteLine($"heard {word}");
                said.AddListener(hear);
                said.Invoke("once");
                said.RemoveListener(hear);
                // Nobody hears it: else there would be a second line.
                said.Invoke("once");
                Console.WriteLine($"JSON of what is in no class: {JsonUtility.ToJson(new[] { 1f })} {JsonUtility.ToJson(new List<int> { 1 })} {JsonUtility.ToJson("a")}");
                foreach (var wrong in new[] { "{\"hp\":}", "{\"hp\":1", "hp", "[1]" })
                    try { Console.WriteLine($"read {wrong}: {JsonUtility.FromJson<Order>(wrong).hp}"); }
                    catch (ArgumentException e) { Console.WriteLine($"no JSON: {e.Message}"); }
                Console.WriteLine(FormattableString.Invariant(
                    $"Mathf: {Mathf.Clamp(5, 0, 3)} {Mathf.MoveTowards(1, -1, 0.5f)} {Mathf.Repeat(-1, 3)} {Mathf.PingPong(5, 3)} {Mathf.DeltaAngle(350, 20)} {Mathf.RoundToInt(2.5f)} {Vector3.MoveTowards(Vector3.zero, Vector3.up * 2, 0.5f)}"));
                var turned = text.transform;
                turned.position = Vector3.one;
                turned.eulerAngles = new Vector3(-10, 200, 30);
                Console.Write($"turned: {turned.eulerAngles}");
                turned.LookAt(thing.transform);
                Console.Write($" {turned.forward.ToString("F3")} {turned.eulerAngles}");
                turned.rotation = Quaternion.AngleAxis(90, Vector3.up * 2);
                turned.Rotate(-90, 0, 0);
                Vector2 flat = new Vector3(3, 6, 9);
                flat += 2 * new Vector2(1, 1) - new Vector2(4, 8) / 2;
                Console.WriteLine($" {turned.eulerAngles} {turned.forward} {flat.magnitude} {(Vector3)(flat * 3f)}");
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
            slow = false;
            Console.WriteLine($"in the scene: {hello.GetComponent<TextMesh>().text.Split('\n')[0]}");
            hello.enabled = false;
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

    [Serializable]
    public sealed class Order
    {
        public int hp;
        public float[] speeds = { 1, 0.5f };
        public List<Vector3> path = new List<Vector3>();
        public Target to = new Target();
        public string text;
        public DateTimeKind kind = DateTimeKind.Utc;
        public readonly int never = 1;
        public Dictionary<string, int> neither = new Dictionary<string, int>();
        [NonSerialized] public bool nor = true;
        [SerializeField] private bool marked = true;
        private int hidden = 5;

        public int Unseen { get => hidden; set => hidden = marked ? value : 0; }

        [Serializable]
        public struct Target
        {
            public string who;
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
