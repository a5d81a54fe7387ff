// ML-Agents' shape, a ray sensor, and below it what rays are cast and what they have met. A script may cast rays
// without one:
//
//     var output = RayPerceptionSensor.Perceive(component.GetRayPerceptionInput());
//     if (output.RayOutputs[0].HitTaggedObject) …
using System;
using System.Collections.Generic;
using UnityEngine;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>Casts rays for each decision.</summary>
    public class RayPerceptionSensor : BuiltInSensor
    {
        private readonly float[] numbers;
        private RayPerceptionInput input;

        public RayPerceptionSensor(string name, RayPerceptionInput rayInput)
            : base(name, ObservationSpec.Vector(rayInput.OutputSize()))
        {
            input = rayInput;
            numbers = new float[input.OutputSize()];
        }

        public RayPerceptionOutput RayPerceptionOutput { get; } = new RayPerceptionOutput();

        /// <summary>Casts rays now.</summary>
        /// <param name="batched">Nothing here depends on it.</param>
        public static RayPerceptionOutput Perceive(RayPerceptionInput input, bool batched = false)
        {
            var output = new RayPerceptionOutput();
            Cast(input, output);
            return output;
        }

        public override void Update() => Cast(input, RayPerceptionOutput);

        public override int Write(ObservationWriter writer)
        {
            Array.Clear(numbers, 0, numbers.Length);
            var tags = input.DetectableTags?.Count ?? 0;
            for (var ray = 0; ray < RayPerceptionOutput.RayOutputs?.Length; ray++)
                RayPerceptionOutput.RayOutputs[ray].ToFloatArray(tags, ray, numbers);
            writer.AddList(numbers);
            return numbers.Length;
        }

        // Its size is that of the first rays: Python was told.
        internal void SetRayPerceptionInput(RayPerceptionInput rayInput)
        {
            if (rayInput.OutputSize() == numbers.Length) input = rayInput;
            else
                Debug.LogError($"{GetName()}: the number of rays and tags cannot change in Play: set it before the "
                    + "agent is enabled");
        }

        private static void Cast(RayPerceptionInput input, RayPerceptionOutput output)
        {
            var count = input.Angles.Count;
            if (output.RayOutputs?.Length != count) output.RayOutputs = new RayPerceptionOutput.RayOutput[count];
            for (var ray = 0; ray < count; ray++) output.RayOutputs[ray] = Cast(input, ray);
        }

        private static RayPerceptionOutput.RayOutput Cast(RayPerceptionInput input, int ray)
        {
            var (start, end) = input.RayExtents(ray);
            var way = end - start;
            var far = way.magnitude;
            var thick = input.RayLength > 0 ? input.CastRadius * far / input.RayLength : input.CastRadius;
            GameObject met;
            float fraction;
            if (input.CastType == RayPerceptionCastType.Cast2D)
            {
                var hit = thick > 0
                    ? Physics2D.CircleCast(start, thick, way, far, input.LayerMask)
                    : Physics2D.Raycast(start, way, far, input.LayerMask);
                (met, fraction) = hit ? (hit.collider.gameObject, hit.fraction) : (null, 1);
            }
            else
            {
                var hits = thick > 0
                    ? Physics.SphereCast(start, thick, way, out var hit, far, input.LayerMask)
                    : Physics.Raycast(start, way, out hit, far, input.LayerMask);
                (met, fraction) = hits ? (hit.collider.gameObject, far > 0 ? hit.distance / far : 0) : (null, 1);
            }
            var tag = met == null ? -1 : TagOf(met, input.DetectableTags);
            return new RayPerceptionOutput.RayOutput
            {
                HasHit = met != null,
                HitTaggedObject = tag >= 0,
                HitTagIndex = tag,
                HitFraction = fraction,
                HitGameObject = met,
                StartPositionWorld = start,
                EndPositionWorld = end,
                ScaledCastRadius = thick,
            };
        }

        private static int TagOf(GameObject met, IReadOnlyList<string> tags)
        {
            for (var tag = 0; tag < tags?.Count; tag++)
                try { if (!string.IsNullOrEmpty(tags[tag]) && met.CompareTag(tags[tag])) return tag; }
                catch (UnityException) { /* The project does not have this tag. */ }
            return -1;
        }
    }

    /// <summary>Whether rays meet colliders of 2D or of 3D.</summary>
    public enum RayPerceptionCastType
    {
        Cast2D,
        Cast3D,
    }

    /// <summary>Some rays from one place.</summary>
    public struct RayPerceptionInput
    {
        /// <summary>In metres; where the thing has the scale 2, they are twice as long.</summary>
        public float RayLength;

        public IReadOnlyList<string> DetectableTags;

        /// <summary>The direction of each, in degrees: 0 to the right, 90 ahead.</summary>
        public IReadOnlyList<float> Angles;

        public float StartOffset;
        public float EndOffset;

        /// <summary>How thick they are, in metres; 0: as thin as a ray.</summary>
        public float CastRadius;

        public Transform Transform;
        public RayPerceptionCastType CastType;
        public int LayerMask;
        public bool UseBatchedRaycasts;

        public int OutputSize() => ((DetectableTags?.Count ?? 0) + 2) * (Angles?.Count ?? 0);

        public (Vector3 StartPositionWorld, Vector3 EndPositionWorld) RayExtents(int rayIndex)
        {
            var angle = Mathf.Deg2Rad * Angles[rayIndex];
            float aside = RayLength * Mathf.Cos(angle), ahead = RayLength * Mathf.Sin(angle);
            var flat = CastType == RayPerceptionCastType.Cast2D;
            var start = new Vector3(0, flat ? 0 : StartOffset, 0);
            var end = flat ? new Vector3(aside, ahead, 0) : new Vector3(aside, EndOffset, ahead);
            return (Transform.TransformPoint(start), Transform.TransformPoint(end));
        }

        // Ahead, then to the right, to the left, further to the right, …; or else from the right to the left.
        internal static float[] AnglesOf(int raysPerDirection, float maxRayDegrees, bool alternating)
        {
            var angles = new float[(2 * raysPerDirection) + 1];
            var step = raysPerDirection > 0 ? maxRayDegrees / raysPerDirection : 0;
            for (var i = 0; i < angles.Length; i++)
            {
                var aside = alternating ? (i + 1) / 2 * (i % 2 == 1 ? -1 : 1) : i - raysPerDirection;
                angles[i] = 90 + (aside * step);
            }
            return angles;
        }
    }

    /// <summary>The results of all rays.</summary>
    public class RayPerceptionOutput
    {
        /// <summary>One for each ray, in the order of the angles; null: none was cast yet.</summary>
        public RayOutput[] RayOutputs;

        /// <summary>The result of one ray.</summary>
        public struct RayOutput
        {
            public bool HasHit;
            public bool HitTaggedObject;
            public int HitTagIndex;

            /// <summary>How far it came, from 0 to 1.</summary>
            public float HitFraction;

            public GameObject HitGameObject;
            public Vector3 StartPositionWorld;
            public Vector3 EndPositionWorld;
            public float ScaledCastRadius;

            /// <summary>How long it is, with the scale of its thing.</summary>
            public float ScaledRayLength => (EndPositionWorld - StartPositionWorld).magnitude;

            /// <summary>Writes its numbers: 1 at its tag, 1 if it has met nothing, and how far it came.</summary>
            /// <param name="buffer">The numbers of all rays, which are 0 before.</param>
            public void ToFloatArray(int numDetectableTags, int rayIndex, float[] buffer)
            {
                var at = (numDetectableTags + 2) * rayIndex;
                if (HitTaggedObject) buffer[at + HitTagIndex] = 1;
                buffer[at + numDetectableTags] = HasHit ? 0 : 1;
                buffer[at + numDetectableTags + 1] = HitFraction;
            }
        }
    }
}
