// Application 20 in Unity: a person, or a hand, of spheres and lines. It needs no model of a human.
//
// Use: add it to an object that has a BodyTracker.
using System;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>A sphere for each landmark, and a thin cube for each line between two of them.</summary>
    [AddComponentMenu("NetMQ Example/20 Pose Skeleton")]
    [RequireComponent(typeof(BodyTracker))]
    public sealed class PoseSkeleton : MonoBehaviour
    {
        [SerializeField, Min(0.001f), Tooltip("How thick a line is, in metres")] private float thickness = 0.02f;

        private BodyTracker tracker;
        private Transform[] joints, lines;
        private (int From, int To)[] pairs;

        private void Start()
        {
            tracker = GetComponent<BodyTracker>();
            var hand = tracker.IsHand;
            var landmarks = new int[hand ? BodyPose.OfAHand : BodyPose.Landmarks];
            joints = Array.ConvertAll(landmarks, i => Part(PrimitiveType.Sphere));
            pairs = hand ? BodyLines.Hand : BodyLines.Body;
            lines = Array.ConvertAll(pairs, line => Part(PrimitiveType.Cube));
        }

        // After every Update, so that it shows this frame's pose. A body without extent is at one point: out of sight.
        private void LateUpdate()
        {
            var size = tracker.Present ? thickness : 0;
            for (var i = 0; i < joints.Length; i++)
            {
                joints[i].localPosition = tracker.Place(i);
                joints[i].localScale = Vector3.one * (2 * size);
            }
            for (var i = 0; i < lines.Length; i++)
            {
                var (from, to) = (tracker.Place(pairs[i].From), tracker.Place(pairs[i].To));
                lines[i].localPosition = (from + to) / 2;
                if (from != to) lines[i].localRotation = Quaternion.LookRotation(to - from);
                lines[i].localScale = new Vector3(size, size, tracker.Present ? (to - from).magnitude : 0);
            }
        }

        private Transform Part(PrimitiveType type)
        {
            var part = Cube.Shape(type, null, transform);
            // It is there to be seen, and pushes nothing.
            Destroy(part.GetComponent<Collider>());
            return part;
        }
    }
}
