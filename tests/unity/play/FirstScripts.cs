// Scripts as game developers write their first ones. Each says what it saw, and quits the game.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using UnityEngine;
using UnityEngine.Events;
using UnityEngine.SceneManagement;
using UnityPlayer;
using static NetMQExample.PlayTest.FirstScripts;
using Random = UnityEngine.Random;

namespace NetMQExample.PlayTest
{
    internal static class FirstScripts
    {
        public static int Play(string script)
        {
            CultureInfo.CurrentCulture = CultureInfo.InvariantCulture;
            var player = new Player(typeof(FirstScripts).Assembly);
            player.Begin(
                () => new GameObject("first").AddComponent(Type.GetType($"NetMQExample.PlayTest.{script}", true)));
            player.Run(TimeSpan.FromSeconds(20), () => false);
            player.Stop();
            Console.WriteLine($"errors: {player.Errors}");
            return 0;
        }

        public static void Say(params object[] parts) => Debug.Log(string.Join(" ", parts));
    }

    public sealed class Waiting : MonoBehaviour
    {
        private int updates, lateUpdates, steps, updatesAtStep;

        // How many frames pass until the next step is up to the clock; that nothing comes between them is not.
        private void FixedUpdate() => (steps, updatesAtStep) = (steps + 1, updates);

        private void Update() => updates++;

        private void LateUpdate() => lateUpdates++;

        private IEnumerator Start()
        {
            print($"Start in frame {Time.frameCount}");
            yield return null;
            print($"null: frame {Time.frameCount}, after Update: {updates == 2 && lateUpdates == 1}");
            yield return new WaitForEndOfFrame();
            print($"end of frame {Time.frameCount}, after LateUpdate: {lateUpdates == 2}");
            var before = steps;
            yield return new WaitForFixedUpdate();
            print($"a step: {steps == before + 1}, before Update: {updates == updatesAtStep}");
            float began = Time.time, real = Time.realtimeSinceStartup;
            yield return new WaitForSeconds(0.05f);
            print($"seconds: {Time.time >= began + 0.05f}");
            Time.timeScale = 0;
            began = Time.time;
            yield return new WaitForSecondsRealtime(0.05f);
            Say("real seconds:", $"{Time.realtimeSinceStartup >= real + 0.1f},", "of none in the game:",
                $"{Time.time == began},", Time.unscaledTime > Time.time);
            Time.timeScale = 1;
            var now = updates;
            yield return new WaitUntil(() => updates >= now + 2);
            yield return new WaitWhile(() => updates < now + 4);
            print($"until and while: {updates - now}");
            yield return new WaitUntil(() => true);
            print($"no wait at all: {updates - now}");
            yield return "anything else";
            print($"a frame: {updates - now}");
            yield return Nested("a part of it");
            yield return StartCoroutine(Nested("one of its own"));
            print($"all in {updates - now} frames");
            yield return StartCoroutine(nameof(Nested), "by its name");
            yield return StartCoroutine(Empty());
            print($"nothing to wait for: {updates - now}");
            Application.Quit();
        }

        private IEnumerator Nested(string what)
        {
            print($"begins: {what}");
            yield return null;
            print($"ends: {what}");
        }

        private IEnumerator Empty()
        {
            yield break;
        }
    }

    // A script whose coroutines others stop; it is on an object of its own.
    public sealed class Counter : MonoBehaviour
    {
        public int Counted { get; private set; }

        public IEnumerator Count()
        {
            while (true)
            {
                Counted++;
                yield return null;
            }
        }

        public IEnumerator CountInside()
        {
            yield return Count();
        }

        public IEnumerator Fail()
        {
            yield return null;
            throw new InvalidOperationException("in a coroutine");
        }
    }

    public sealed class Stopping : MonoBehaviour
    {
        private Counter other;

        private IEnumerator Start()
        {
            var holder = new GameObject("holder");
            (other = new GameObject("counter").AddComponent<Counter>()).transform.SetParent(holder.transform);
            var routine = other.Count();
            other.StartCoroutine(routine);
            yield return Ended("by its routine", () => other.StopCoroutine(routine));
            var handle = other.StartCoroutine(other.CountInside());
            yield return Ended("by its handle, with what is inside", () => other.StopCoroutine(handle));
            other.StartCoroutine(nameof(other.Count));
            yield return Ended("by its name", () => other.StopCoroutine(nameof(other.Count)));
            other.StartCoroutine(other.Count());
            other.StartCoroutine(nameof(other.Count));
            yield return Ended("all", other.StopAllCoroutines);
            other.StartCoroutine(other.Count());
            yield return Ended("switched off", () => other.enabled = false);
            yield return Ended("with the object above it", () => holder.SetActive(false));
            print($"none: {other.StartCoroutine(other.Count()) == null}");
            holder.SetActive(true);
            yield return Ended("active again", () => { });
            other.enabled = true;
            other.StartCoroutine(other.Fail());
            other.StartCoroutine(other.Count());
            yield return null;
            yield return Ended("after another has failed", () => { });
            var counter = other;
            yield return Ended("destroyed", () => Destroy(counter));
            Application.Quit();
        }

        private IEnumerator Ended(string what, Action stop)
        {
            yield return null;
            stop();
            yield return new WaitForEndOfFrame();
            var before = other.Counted;
            yield return null;
            yield return null;
            print($"{what}: {(other.Counted == before ? "ended" : "goes on")}");
        }
    }

    public sealed class Later : MonoBehaviour
    {
        private readonly List<string> calls = new List<string>();
        private float began;

        private void Start()
        {
            began = Time.time;
            InvokeRepeating(nameof(Once), 0.02f, 0.0001f);
            Invoke(nameof(Soon), 0.05f);
            Invoke("Never", 0.05f);
            InvokeRepeating(nameof(Again), 0.02f, 0.03f);
            Destroy(new GameObject("doomed"), 0.05f);
            Destroy(new GameObject("doomed much later"), 1000);
            Destroy(new GameObject("doomed at once"));
            print($"pending: {IsInvoking()} {IsInvoking(nameof(Soon))} {IsInvoking(nameof(Last))}");
            CancelInvoke("Never");
            enabled = false;
        }

        private void Soon() =>
            Say("soon:", $"{Time.time >= began + 0.05f},", "though disabled:", $"{!enabled},",
                GameObject.Find("doomed at once") == null);

        private void Never() => print("never");

        // Due several times within a frame.
        private void Once()
        {
            print("once");
            CancelInvoke(nameof(Once));
        }

        private void Again()
        {
            calls.Add("again");
            if (calls.Count < 3) return;
            CancelInvoke(nameof(Again));
            Invoke("NoSuchMethod", 0);
            Invoke(nameof(Last), 0.05f);
        }

        private void Last()
        {
            Say("times:", $"{calls.Count},", "doomed:", GameObject.Find("doomed") != null,
                $"{GameObject.Find("doomed much later") != null},", "pending:", IsInvoking(nameof(Again)));
            InvokeRepeating(nameof(Again), 1, 1);
            CancelInvoke();
            print($"pending: {IsInvoking()}");
            Application.Quit();
        }
    }

    [Serializable]
    public sealed class Loot
    {
        public string what = "nothing";
        public List<int> coins = new List<int>();
    }

    public sealed class Enemy : MonoBehaviour
    {
        public int health = 3;
        public Loot loot = new Loot();
        public Transform[] parts = new Transform[0];
        public Color tint = Color.white;
        [SerializeField] private string kind = "rat";
        private int hits;

        public string Told =>
            $"{kind} {health} {hits} {loot.what} {Listed(loot.coins)} "
            + $"{Listed(parts.Select(part => part.name))} {tint.g}";

        private static string Listed<T>(IEnumerable<T> items) => items.Any() ? string.Join("+", items) : "none";

        public void Become(string what) => (kind, hits) = (what, hits + 1);

        private void Awake() => print($"awake: {name} at {transform.position}, {Told}");
    }

    public sealed class Things : MonoBehaviour
    {
        private void Start()
        {
            var enemy = new GameObject("Enemy") { tag = "Player" }.AddComponent<Enemy>();
            var hand = new GameObject("Hand").transform;
            hand.SetParent(new GameObject("Arm").transform);
            hand.parent.SetParent(enemy.transform);
            hand.localPosition = Vector3.right;
            (enemy.health, enemy.tint, enemy.loot.what, enemy.parts) = (7, Color.red, "a sword",
                new[] { hand, transform });
            enemy.loot.coins.Add(5);
            enemy.Become("wolf");
            enemy.gameObject.AddComponent<MeshRenderer>().material.color = Color.red;

            var copy = Instantiate(enemy, new Vector3(1, 2, 3), Quaternion.Euler(0, 90, 0));
            copy.loot.coins.Add(6);
            copy.GetComponent<Renderer>().material.color = Color.blue;
            Say("its own:", $"{copy.parts[0] != hand && copy.parts[0].root == copy.transform},",
                $"{copy.parts[1] == transform},", $"{enemy.Told},",
                enemy.GetComponent<Renderer>().material.color == Color.red);
            print($"its hand: {copy.transform.Find("Arm/Hand").position}, {copy.transform.Find("Hand") == null}");
            var below = Instantiate(copy.gameObject, hand);
            print($"below: {below.transform.position} {below.transform.parent.name} {below.name}");
            below.SetActive(false);
            print($"below and placed: {Instantiate(below, Vector3.up, Quaternion.identity, hand).transform.position}");

            hand.parent.localScale = Vector3.one * 2;
            print($"scaled: {hand.position} {hand.lossyScale}");
            hand.SetParent(null);
            print($"let go: {hand.position} {hand.localScale}");
            hand.SetParent(enemy.transform, false);
            Search(enemy, copy);
            Moves();
            Application.Quit();
        }

        private static void Search(Enemy enemy, Enemy copy)
        {
            Say("by type:", FindObjectsByType<Enemy>(FindObjectsSortMode.None).Length,
                FindObjectsByType<Enemy>(FindObjectsInactive.Include).Length,
                FindObjectsOfType<GameObject>().Length > 5, FindAnyObjectByType<Camera>() == null,
                FindObjectOfType<Things>().name, FindFirstObjectByType<Enemy>().name);
            Say("by name:", GameObject.Find("Enemy/Arm").name, GameObject.Find("/Hand") == null,
                GameObject.Find("Enemy(Clone)").transform == copy.transform);
            Say("by tag:", GameObject.FindWithTag("Player").name, GameObject.FindGameObjectsWithTag("Player").Length,
                GameObject.FindWithTag("none") == null);
            Say("around:", enemy.GetComponentInChildren<Renderer>() != null,
                enemy.transform.Find("Hand").GetComponentInParent<Enemy>() == enemy,
                enemy.TryGetComponent<Camera>(out _), enemy.GetComponents<Component>().Length,
                copy.GetComponentsInChildren<Transform>().Length);
            copy.transform.GetChild(0).gameObject.SetActive(false);
            Say("active:", copy.GetComponentsInChildren<Transform>().Length,
                copy.GetComponentsInChildren<Transform>(true).Length,
                copy.transform.Find("Arm/Hand").gameObject.activeSelf,
                copy.transform.Find("Arm/Hand").gameObject.activeInHierarchy, copy.transform.childCount);
            foreach (Transform child in enemy.transform) Destroy(child.gameObject);
        }

        private void Moves()
        {
            transform.Translate(Vector3.forward * 2);
            transform.Rotate(Vector3.up, 90);
            transform.Translate(0, 0, 1);
            transform.Translate(Vector3.up, Space.World);
            Say("moved:", transform.position, transform.right, transform.TransformPoint(Vector3.forward),
                transform.InverseTransformPoint(Vector3.zero));
            transform.Rotate(90, 0, 0, Space.World);
            print($"turned: {transform.forward} {transform.up}");
            transform.RotateAround(Vector3.zero, Vector3.up, 180);
            print($"around: {transform.position} {transform.forward}");
            transform.up = Vector3.right;
            print($"up: {transform.up} {transform.InverseTransformDirection(Vector3.right)}");
        }
    }

    public sealed class Sums : MonoBehaviour
    {
        private void Start()
        {
            Vector3 a = new Vector3(3, 4), b = Vector3.back;
            Say(a.normalized, -a, Vector3.Dot(a, a), Vector3.Angle(a, b),
                Vector3.SignedAngle(Vector3.right, Vector3.up, b), $"{Vector3.Distance(a, b):F3}");
            Say(Vector3.Slerp(Vector3.right, Vector3.up * 3, 0.5f), Vector3.Slerp(Vector3.zero, a, 0.5f),
                Vector3.ClampMagnitude(a, 1), Vector3.Project(a, Vector3.left), Vector3.ProjectOnPlane(a, Vector3.up),
                Vector3.LerpUnclamped(a, b, 2));
            var velocity = Vector3.zero;
            var near = Vector3.SmoothDamp(Vector3.zero, a, ref velocity, 0.3f);
            print($"{near.x > 0 && near.x < 3} {Vector3.Dot(velocity, a) > 0}");
            Vector2 flat = a;
            Say(flat.normalized, $"{Vector2.Distance(flat, Vector2.up):F2}",
                Vector2.MoveTowards(flat, Vector2.zero, 5) == Vector2.zero, -flat,
                Vector2.Lerp(flat, Vector2.one, 0.5f));
            Quaternion left = Quaternion.Euler(0, -60, 0), right = Quaternion.Euler(0, 60, 0);
            Say($"{Quaternion.Angle(left, right):F1}", Quaternion.Slerp(left, right, 0.25f).eulerAngles,
                Quaternion.Lerp(left, right, 0.5f) == Quaternion.identity,
                Quaternion.RotateTowards(left, right, 30).eulerAngles,
                $"{Quaternion.Slerp(Quaternion.Euler(0, 350, 0), Quaternion.Euler(0, 10, 0), 0.5f).eulerAngles.y:F0}",
                right);
            Say(Mathf.LerpAngle(350, 20, 0.5f), Mathf.SmoothStep(0, 10, 0.5f), Mathf.Approximately(0.1f + 0.2f, 0.3f),
                Mathf.Max(1, 5, 3), Mathf.Min(2f, 0.5f, 1f), $"{Mathf.Asin(1) * Mathf.Rad2Deg:F0}", Mathf.Log(8, 2));
            Say(Color.Lerp(Color.black, Color.white, 0.5f), Color.red * 0.5f, ((Color32)Color.yellow).g,
                Color.grey == Color.gray);
            Random.InitState(1);
            var many = Enumerable.Range(0, 300).Select(_ => Random.insideUnitSphere).ToArray();
            Say(many.All(one => one.magnitude <= 1), many.Any(one => one.y > 0.5f) && many.Any(one => one.z < -0.5f),
                $"{Random.onUnitSphere.magnitude:F2}", Random.insideUnitCircle.magnitude <= 1,
                Quaternion.Dot(Random.rotation, Quaternion.identity) <= 1);
            Application.Quit();
        }
    }

    public sealed class Parts : MonoBehaviour
    {
        private readonly UnityEvent shot = new UnityEvent();

        private void Start()
        {
            shot.AddListener(() => Debug.LogFormat("{0} of {1:F1}", "a shot", 1.5f));
            shot.Invoke();
            Debug.LogWarningFormat("a warning for {0}", name);
            Debug.Assert(true, "never said");
            Debug.Assert(1 > 2);
            Debug.DrawRay(Vector3.zero, Vector3.up, Color.red);
            PlayerPrefs.SetInt("score", 5);
            PlayerPrefs.SetString("name", "Ann");
            Say("prefs:", PlayerPrefs.GetInt("score"), PlayerPrefs.GetInt("other", -1), PlayerPrefs.GetFloat("score"),
                PlayerPrefs.HasKey("name"), $"'{PlayerPrefs.GetString("none")}'");
            PlayerPrefs.DeleteAll();
            Say("keys:", Input.GetKeyUp(KeyCode.Escape), Input.GetButtonDown("Jump"), Input.GetAxisRaw("Mouse X"),
                Input.GetMouseButton(0), Input.anyKey, (int)KeyCode.Z, (int)KeyCode.F12);
            var order = new Loot { what = "tea", coins = { 1, 2 } };
            print(JsonUtility.ToJson(order, true));
            Say("json:", JsonUtility.FromJson<Loot>("") == null,
                ((Loot)JsonUtility.FromJson(JsonUtility.ToJson(order), typeof(Loot))).coins.Count,
                JsonUtility.ToJson(new Pose(Vector3.one, Quaternion.identity)));
            JsonUtility.FromJsonOverwrite("", order);
            JsonUtility.FromJsonOverwrite("{\"what\":\"milk\"}", order);
            try { JsonUtility.ToJson(transform); }
            catch (ArgumentException e) { print($"{order.what} {order.coins.Count}: {e.Message}"); }
            Time.fixedDeltaTime = 0.01f;
            print($"step: {Time.fixedDeltaTime}, of {SceneManager.GetActiveScene().name}");
        }

        private void OnGUI()
        {
            GUILayout.BeginArea(new Rect(10, 10, Screen.width / 2f, 100));
            GUILayout.Label($"frame {Time.frameCount}", GUILayout.Width(100));
            if (GUILayout.Button("Go") || GUI.Button(new Rect(0, 0, 10, 10), "Go")) print("nobody clicks");
            print($"drawn: {Player.Drawn}, {GUILayout.TextField("as it was")}");
            GUILayout.EndArea();
            Application.Quit();
        }
    }
}
