// ML-Agents' shape, a ray sensor. A script may cast rays without one:
//
//     var output = RayPerceptionSensor.Perceive(component.GetRayPerceptionInput());
//     if (output.RayOutputs[0].HitTaggedObject) …
using System;
using UnityEngine;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>Casts rays for each decision.</summary>
    public class RayPerceptionSensor : BuiltInSensor
    {
        private readonly float[] numbers;
        private RayPerceptionInput input;

        /// <summary>With its name and its rays.</summary>
        public RayPerceptionSensor(string name, RayPerceptionInput rayInput)
            : base(name, ObservationSpec.Vector(rayInput.OutputSize()))
        {
            input = rayInput;
            numbers = new float[input.OutputSize()];
        }

        /// <summary>The last results of its rays.</summary>
        public RayPerceptionOutput RayPerceptionOutput { get; } = new RayPerceptionOutput();

        /// <summary>Casts rays now.</summary>
        /// <param name="input">The rays.</param>
        /// <param name="batched">Nothing here depends on it.</param>
        public static RayPerceptionOutput Perceive(RayPerceptionInput input, bool batched = false)
        {
            var output = new RayPerceptionOutput { RayOutputs = new RayPerceptionOutput.RayOutput[input.Angles.Count] };
            for (var ray = 0; ray < input.Angles.Count; ray++) output.RayOutputs[ray] = Cast(input, ray);
            return output;
        }

        /// <inheritdoc/>
        public override void Update()
        {
            var count = input.Angles.Count;
            if (RayPerceptionOutput.RayOutputs?.Length != count)
                RayPerceptionOutput.RayOutputs = new RayPerceptionOutput.RayOutput[count];
            for (var ray = 0; ray < count; ray++) RayPerceptionOutput.RayOutputs[ray] = Cast(input, ray);
        }

        /// <inheritdoc/>
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

        internal static RayPerceptionOutput.RayOutput Cast(RayPerceptionInput input, int ray)
        {
            var (start, end) = input.RayExtents(ray);
            var way = end - start;
            var far = way.magnitude;
            var thick = input.RayLength > 0 ? input.CastRadius * far / input.RayLength : input.CastRadius;
            GameObject met = null;
            var fraction = 1f;
            if (input.CastType == RayPerceptionCastType.Cast2D)
            {
                var hit = thick > 0
                    ? Physics2D.CircleCast(start, thick, way, far, input.LayerMask)
                    : Physics2D.Raycast(start, way, far, input.LayerMask);
                if (hit)
                {
                    met = hit.collider.gameObject;
                    fraction = hit.fraction;
                }
            }
            else if (thick > 0
                ? Physics.SphereCast(start, thick, way, out var hit, far, input.LayerMask)
                : Physics.Raycast(start, way, out hit, far, input.LayerMask))
            {
                met = hit.collider.gameObject;
                fraction = far > 0 ? hit.distance / far : 0;
            }
            var tag = TagOf(met, input);
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

        private static int TagOf(GameObject met, RayPerceptionInput input)
        {
            for (var tag = 0; met != null && tag < (input.DetectableTags?.Count ?? 0); tag++)
            {
                // Of a tag that the project does not have, nothing is met.
                try
                {
                    if (!string.IsNullOrEmpty(input.DetectableTags[tag]) && met.CompareTag(input.DetectableTags[tag]))
                        return tag;
                }
                catch (UnityException) { }
            }
            return -1;
        }
    }
}
