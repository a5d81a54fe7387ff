// Application 20's numbers and scripts, as the test says:
//
//     numbers=FILE          no Play: of each message of the file the landmarks, the right knee, and what the filter
//                           makes
//     frames=1000           prints what so many frames cost
//     bones=hidden          the character is human, and shows none of its bones
//     character=none        the field is empty, in the editor
//     endpoint=tcp://127.0.0.1:5570 …     and the serialized fields, for a Play to its end with a character in its
//                                         T-pose
//
// At the end of a Play it prints how each limb of the character points and its trunk looks, and how fast a joint of the
// skeleton was at most.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Globalization;
using System.IO;
using System.Linq;
using System.Reflection;
using System.Threading;
using UnityEngine;
using UnityPlayer;

namespace NetMQExample.PlayTest
{
    internal static class Bodies
    {
        private const double Dt = 1 / 60.0;

        // A T-pose, which faces z: where each part is, seen from the part that carries it.
        private static readonly (HumanBodyBones Bone, int Carrier, Vector3 Place)[] TPose =
        {
            (HumanBodyBones.Hips, -1, Vector3.up),
            (HumanBodyBones.Spine, (int)HumanBodyBones.Hips, Vector3.up * 0.2f),
            (HumanBodyBones.Head, (int)HumanBodyBones.Spine, Vector3.up * 0.5f),
            (HumanBodyBones.LeftUpperArm, (int)HumanBodyBones.Spine, new Vector3(-0.2f, 0.3f, 0)),
            (HumanBodyBones.LeftLowerArm, (int)HumanBodyBones.LeftUpperArm, Vector3.right * -0.3f),
            (HumanBodyBones.LeftHand, (int)HumanBodyBones.LeftLowerArm, Vector3.right * -0.25f),
            (HumanBodyBones.RightUpperArm, (int)HumanBodyBones.Spine, new Vector3(0.2f, 0.3f, 0)),
            (HumanBodyBones.RightLowerArm, (int)HumanBodyBones.RightUpperArm, Vector3.right * 0.3f),
            (HumanBodyBones.RightHand, (int)HumanBodyBones.RightLowerArm, Vector3.right * 0.25f),
            (HumanBodyBones.LeftUpperLeg, (int)HumanBodyBones.Hips, new Vector3(-0.1f, 0, 0)),
            (HumanBodyBones.LeftLowerLeg, (int)HumanBodyBones.LeftUpperLeg, Vector3.up * -0.45f),
            (HumanBodyBones.LeftFoot, (int)HumanBodyBones.LeftLowerLeg, Vector3.up * -0.45f),
            (HumanBodyBones.LeftToes, (int)HumanBodyBones.LeftFoot, new Vector3(0, -0.05f, 0.15f)),
            (HumanBodyBones.RightUpperLeg, (int)HumanBodyBones.Hips, new Vector3(0.1f, 0, 0)),
            (HumanBodyBones.RightLowerLeg, (int)HumanBodyBones.RightUpperLeg, Vector3.up * -0.45f),
            // It has no toes, as many a character.
            (HumanBodyBones.RightFoot, (int)HumanBodyBones.RightLowerLeg, Vector3.up * -0.45f),
        };

        public static int Run(string[] words)
        {
            var told = words.Select(word => word.Split(new[] { '=' }, 2))
                .ToDictionary(pair => pair[0], pair => pair[1]);
            if (told.Remove("numbers", out var file)) return Numbers(file);
            var frames = told.Remove("frames", out var many) ? int.Parse(many, CultureInfo.InvariantCulture) : 0;
            var hidden = told.Remove("bones");
            var bare = told.Remove("character");
            Application.Editor = bare;
            var player = new Player(typeof(NetMQLifetime).Assembly);
            var bones = new Dictionary<HumanBodyBones, Transform>();
            GameObject thing = null;
            player.Begin(() =>
            {
                var character = Character(bones);
                foreach (var bone in bones.Keys.Where(_ => hidden)) character.Bones[bone] = null;
                thing = new GameObject("body");
                thing.SetActive(false);
                var types = new[] { typeof(BodyTracker), typeof(PoseAvatar), typeof(PoseSkeleton) };
                var scripts = Scripts.AddTo(thing, types);
                foreach (var setting in told) Inspector.Set(scripts, setting.Key, setting.Value);
                if (!bare) Field(scripts[1], "character").SetValue(scripts[1], character);
                thing.SetActive(true);
            });
            var cost = new FrameCost(Math.Max(frames, 1));
            var tracker = thing.GetComponent<BodyTracker>();
            var (before, fastest, clock) = (new Vector3[BodyPose.Landmarks], 0.0, Stopwatch.StartNew());
            var joints = default(Transform[]);
            for (long frame = 1, there = 0; !player.Done && !(frames > 0 && cost.Done); frame++)
            {
                cost.Begin();
                player.Frame();
                cost.End();
                joints = joints ?? Parts(thing, "joints");
                for (var i = 0; i < joints.Length && tracker.Present; i++)
                {
                    var now = joints[i].localPosition;
                    if (there > 0) fastest = Math.Max(fastest, (now - before[i]).magnitude / Time.deltaTime);
                    before[i] = now;
                }
                if (tracker.Present) there++;
                var rest = TimeSpan.FromSeconds(frame * Dt) - clock.Elapsed;
                if (rest > TimeSpan.Zero) Thread.Sleep(rest);
            }
            if (frames > 0) Console.WriteLine($"cost: {cost}");
            var lines = Parts(thing, "lines");
            Console.WriteLine($"skeleton: {joints.Length} joints, {lines.Count(line => line.localScale.z > 0)} lines");
            foreach (var limb in AvatarLimbs.All.Where(limb => bones.ContainsKey(limb.End)))
                Say($"{limb.Bone} points", bones[limb.End].position - bones[limb.Bone].position);
            foreach (var bone in new[] { HumanBodyBones.Hips, HumanBodyBones.Spine, HumanBodyBones.Head,
                HumanBodyBones.LeftLowerLeg })
                Say($"{bone} looks", bones[bone].rotation * Forward(bone));
            Console.WriteLine(FormattableString.Invariant($"fastest {fastest:F3} m/s"));
            player.Stop();
            return player.Errors > 0 ? 1 : 0;
        }

        private static void Say(string what, Vector3 direction)
        {
            var way = direction / direction.magnitude;
            Console.WriteLine(FormattableString.Invariant($"{what} {way.x:F4} {way.y:F4} {way.z:F4}"));
        }

        private static Transform[] Parts(GameObject thing, string name)
        {
            var skeleton = thing.GetComponent<PoseSkeleton>();
            return (Transform[])Field(skeleton, name).GetValue(skeleton);
        }

        private static FieldInfo Field(object script, string name) =>
            script.GetType().GetField(name, BindingFlags.Instance | BindingFlags.NonPublic);

        // As models have it, a bone's own axes are any: here each one is turned by another angle.
        private static Quaternion Own(HumanBodyBones bone) => Quaternion.Euler(20 * (int)bone, 35 * (int)bone, 10);
        private static Vector3 Forward(HumanBodyBones bone) => Quaternion.Inverse(Own(bone)) * Vector3.forward;

        private static Animator Character(Dictionary<HumanBodyBones, Transform> bones)
        {
            var character = new GameObject("character").AddComponent<Animator>();
            foreach (var (bone, carrier, place) in TPose)
            {
                var part = new GameObject($"{bone}").transform;
                var above = carrier < 0 ? character.transform : bones[(HumanBodyBones)carrier];
                part.SetPositionAndRotation(above.position + place, Own(bone));
                part.SetParent(above);
                character.Bones[bone] = bones[bone] = part;
            }
            return character;
        }

        private static int Numbers(string file)
        {
            var filter = new OneEuroFilter(3 * BodyPose.Landmarks);
            foreach (var message in File.ReadAllLines(file))
            {
                var pose = BodyPose.Parse(message);
                Print("pose", pose == null ? new double[0] : new[] { pose.Number, pose.Seconds });
                if (pose?.Places == null) continue;
                Print("places", pose.Places);
                Print("visibility", pose.Visibility);
                Print("knee", new[] { pose.Angle(24, 26, 28) });
                for (var i = 0; i < 2; i++) filter.Step(pose.Places, Dt);
                Print("smooth", filter.Values);
            }
            return 0;
        }

        // Seventeen digits say a double to the bit, on every runtime.
        private static void Print(string name, double[] numbers)
        {
            var written = numbers.Select(number => number.ToString("G17", CultureInfo.InvariantCulture));
            Console.WriteLine($"{name} {string.Join(" ", written)}");
        }
    }
}
