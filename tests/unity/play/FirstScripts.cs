// Scripts as game developers write their first ones. Each says what it saw, and quits the game.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using UnityEngine;
using UnityPlayer;
using static NetMQExample.PlayTest.FirstScripts;

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
}
