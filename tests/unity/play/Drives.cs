// Plays of lesson 08 to their end, with what may happen to it; a word -- begins the next one:
//
//     topfirst, noreadback, nographics       another graphics card, or none
//     fail=20                                three readbacks end with an error after so many steps
//     press=20                               somebody takes over after so many steps, and gives back 40 later
//     down=20                                somebody holds the down key from so many steps on
//     disable=20                             the sender is switched off after so many steps, and on 10 later
//     eye                                    another camera is the driver's eye: it looks at the sky, which is red
//     numbered                               the sky's colour is the number of the step
//     positions                              prints where the car is after each step
//     frames=1000                            prints what so many frames cost, but for what the graphics card does
//     endpoint=tcp://127.0.0.1:5558 …        and the serialized fields
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Globalization;
using System.Linq;
using System.Reflection;
using System.Threading;
using UnityEngine;
using UnityEngine.Rendering;
using UnityPlayer;

namespace NetMQExample.PlayTest
{
    internal static class Drives
    {
        private const BindingFlags Hidden = BindingFlags.Instance | BindingFlags.NonPublic;

        public static int Run(string[] words)
        {
            var next = Array.IndexOf(words, "--");
            return next < 0 ? PlayOne(words) : PlayOne(words.Take(next)) | Run(words.Skip(next + 1).ToArray());
        }

        private static int PlayOne(IEnumerable<string> words)
        {
            var told = words.Select(word => word.Split(new[] { '=' }, 2))
                .ToDictionary(pair => pair[0], pair => pair.ElementAtOrDefault(1) ?? "");
            int At(string name) => told.Remove(name, out var text) ? int.Parse(text, CultureInfo.InvariantCulture) : -1;
            (SystemInfo.TopRowFirst, SystemInfo.NoReadback, SystemInfo.NoGraphics) = (told.Remove("topfirst"),
                told.Remove("noreadback"), told.Remove("nographics"));
            int fail = At("fail"), press = At("press"), down = At("down"), disable = At("disable"),
                frames = At("frames");
            var (numbered, positions, looked) = (told.Remove("numbered"), told.Remove("positions"), told.Remove("eye"));
            Camera eye = null;
            var lessons = typeof(NetMQLifetime).Assembly;
            var player = new Player(lessons);
            CameraSender sender = null;
            DrivenCar car = null;
            player.Begin(() =>
            {
                var thing = new GameObject("car");
                thing.SetActive(false);
                var scripts = Scripts.AddTo(thing, Scripts.Of(lessons, "8"));
                foreach (var setting in told) Inspector.Set(scripts, setting.Key, setting.Value);
                thing.SetActive(true);
                (sender, car) = (thing.GetComponent<CameraSender>(), thing.GetComponent<DrivenCar>());
                if (looked)
                {
                    eye = new GameObject("eye").AddComponent<Camera>();
                    eye.transform.SetPositionAndRotation(Vector3.up, Quaternion.Euler(-90, 0, 0));
                    eye.backgroundColor = new Color32(200, 0, 0, 255);
                    car.Eye = eye;
                }
                // It comes after the car: its FixedUpdate sees what the car's has done.
                var other = new GameObject("numbers");
                if (numbered) other.AddComponent<NumberedSky>().Sender = sender;
            });
            var cost = new FrameCost(Math.Max(frames, 1));
            // A frame in which a line is logged does not count: the line itself is memory.
            var logged = false;
            Application.logMessageReceived += (line, stack, type) => logged = true;
            var clock = Stopwatch.StartNew();
            for (long frame = 1, step = -1; !(player.Done && (sender.enabled || disable < 0))
                && !(frames > 0 && cost.Done); frame++)
            {
                var rendering = Camera.Rendering.Elapsed;
                logged = false;
                cost.Begin();
                player.Frame();
                if (!logged) cost.End((Camera.Rendering.Elapsed - rendering).TotalMilliseconds);
                var now = car.Drive.Frame;
                if (positions && now != step)
                    Console.WriteLine(
                        FormattableString.Invariant($"at {now} {car.Car.X:R} {car.Car.Y:R} {Stands(car)}"));
                if (step < fail && now >= fail) AsyncGPUReadback.ToFail = 3;
                if (step < press && now >= press) Player.Press(-0.5f, 1);
                if (press >= 0 && step < press + 20 && now >= press + 20) Player.Press(0, 0);
                if (press >= 0 && step < press + 40 && now >= press + 40) Player.Press(0, 0, KeyCode.Return);
                if (step < down && now >= down) Player.Press(0, -1);
                if (step < disable && now >= disable) sender.enabled = false;
                if (disable >= 0 && step < disable + 10 && now >= disable + 10)
                {
                    sender.enabled = true;
                    // At once, while the sender's thread has only begun.
                    player.Frame();
                }
                step = now;
                var rest = TimeSpan.FromSeconds(frame / 60.0) - clock.Elapsed;
                if (rest > TimeSpan.Zero) Thread.Sleep(rest);
            }
            var text = (string)typeof(CameraSender).GetField("text", Hidden).GetValue(sender);
            if (text != "") Console.WriteLine($"the inspector shows {text}");
            if (frames > 0) Console.WriteLine($"cost: {cost}");
            if (looked)
                Console.WriteLine(
                    $"the eye goes on as it was: {eye != null && eye.enabled && eye.targetTexture == null}");
            player.Stop();
            return player.Errors > 0 ? 1 : 0;
        }

        private static bool Stands(DrivenCar car)
        {
            var (place, ahead) = (car.transform.position, car.transform.rotation * Vector3.forward);
            return place == new Vector3((float)car.Car.X, 0, (float)car.Car.Y)
                && (ahead - new Vector3((float)car.Car.AheadX, 0, (float)car.Car.AheadY)).magnitude < 0.001f;
        }

        /// <summary>So a picture says when it was rendered.</summary>
        private sealed class NumberedSky : MonoBehaviour
        {
            public CameraSender Sender { get; set; }

            private void FixedUpdate()
            {
                var taker = typeof(CameraSender).GetField("taker", Hidden).GetValue(Sender);
                if (taker == null) return;
                var number = Sender.GetComponent<DrivenCar>().Drive.Frame;
                foreach (var camera in (Camera[])typeof(PictureTaker).GetField("cameras", Hidden).GetValue(taker))
                    camera.backgroundColor = new Color32((byte)number, (byte)(number >> 8), 200, 255);
            }
        }
    }
}
