// A character: which of its parts is which bone of a human. The player has no models, so a test says it.
using System.Collections.Generic;

namespace UnityEngine
{
    public enum HumanBodyBones
    {
        Hips, LeftUpperLeg, RightUpperLeg, LeftLowerLeg, RightLowerLeg, LeftFoot, RightFoot, Spine, Chest, Neck, Head,
        LeftShoulder, RightShoulder,
        LeftUpperArm, RightUpperArm, LeftLowerArm, RightLowerArm, LeftHand, RightHand, LeftToes, RightToes,
    }

    public class Animator : Behaviour
    {
        internal Dictionary<HumanBodyBones, Transform> Bones { get; } = new Dictionary<HumanBodyBones, Transform>();
        public bool isHuman => Bones.Count > 0;

        /// <summary>Null for a bone that this character does not have.</summary>
        public Transform GetBoneTransform(HumanBodyBones humanBoneId)
        {
            MainThread.Only(nameof(GetBoneTransform));
            return Bones.TryGetValue(humanBoneId, out var bone) ? bone : null;
        }
    }
}
