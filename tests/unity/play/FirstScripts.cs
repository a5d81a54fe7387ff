// Scripts as game developers write their first ones. Each says what it saw, and quits the game.
using System;
using System.Collections;
using System.Globalization;
using UnityEngine;
using UnityEngine.Rendering;
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

    public sealed class Seeing : MonoBehaviour
    {
        private void Start() => AsyncGPUReadback.Request(new RenderTexture(2, 1, 24), 0, TextureFormat.RGBA32, Seen);

        private static void Seen(AsyncGPUReadbackRequest request)
        {
            print($"frame {Time.frameCount}: {request.GetData<byte>().ToArray().Length} bytes");
            Application.Quit();
            throw new InvalidOperationException("in a callback");
        }
    }
}
