// ML-Agents' shape, what rays are cast, and what they have met.
using System.Collections.Generic;
using UnityEngine;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>Whether rays meet colliders of 2D or of 3D.</summary>
    public enum RayPerceptionCastType
    {
        /// <summary>Rays in the plane of x and y.</summary>
        Cast2D,
        /// <summary>Rays in the plane of x and z.</summary>
        Cast3D,
    }

    /// <summary>Some rays from one place.</summary>
    public struct RayPerceptionInput
    {
        /// <summary>In metres; where the thing has the scale 2, they are twice as long.</summary>
        public float RayLength;

        /// <summary>The tags that they tell apart.</summary>
        public IReadOnlyList<string> DetectableTags;

        /// <summary>The direction of each, in degrees: 0 to the right, 90 ahead.</summary>
        public IReadOnlyList<float> Angles;

        /// <summary>How much higher they begin; 3D only.</summary>
        public float StartOffset;

        /// <summary>How much higher they end; 3D only.</summary>
        public float EndOffset;

        /// <summary>How thick they are, in metres; 0: as thin as a ray.</summary>
        public float CastRadius;

        /// <summary>The thing.</summary>
        public Transform Transform;

        /// <summary>2D or 3D.</summary>
        public RayPerceptionCastType CastType;

        /// <summary>The layers that they meet.</summary>
        public int LayerMask;

        /// <summary>Nothing here depends on it.</summary>
        public bool UseBatchedRaycasts;

        /// <summary>How many numbers they make.</summary>
        public int OutputSize() => ((DetectableTags?.Count ?? 0) + 2) * (Angles?.Count ?? 0);

        /// <summary>Where a ray begins and ends.</summary>
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
            /// <summary>Whether it has met anything.</summary>
            public bool HasHit;

            /// <summary>Whether that has one of the tags.</summary>
            public bool HitTaggedObject;

            /// <summary>Which one; -1: none.</summary>
            public int HitTagIndex;

            /// <summary>How far it came, from 0 to 1.</summary>
            public float HitFraction;

            /// <summary>The thing that it has met, or null.</summary>
            public GameObject HitGameObject;

            /// <summary>Where it begins.</summary>
            public Vector3 StartPositionWorld;

            /// <summary>Where it would end.</summary>
            public Vector3 EndPositionWorld;

            /// <summary>How thick it is, with the scale of its thing.</summary>
            public float ScaledCastRadius;

            /// <summary>How long it is, with the scale of its thing.</summary>
            public float ScaledRayLength => (EndPositionWorld - StartPositionWorld).magnitude;

            /// <summary>Writes its numbers: 1 at its tag, 1 if it has met nothing, and how far it came.</summary>
            /// <param name="numDetectableTags">How many tags there are.</param>
            /// <param name="rayIndex">Which ray it is.</param>
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
