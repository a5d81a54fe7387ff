// A character: which of its parts is which bone of a human. The player has no models, so a test says it.
using System.Collections.Generic;

namespace UnityEngine
{
    public enum HumanBodyBones
    {
        Hips = 0,
        LeftUpperLeg = 1,
        RightUpperLeg = 2,
        LeftLowerLeg = 3,
        RightLowerLeg = 4,
        LeftFoot = 5,
        RightFoot = 6,
        Spine = 7,
        Chest = 8,
        Neck = 9,
        Head = 10,
        LeftShoulder = 11,
        RightShoulder = 12,
        LeftUpperArm = 13,
        RightUpperArm = 14,
        LeftLowerArm = 15,
        RightLowerArm = 16,
        LeftHand = 17,
        RightHand = 18,
        LeftToes = 19,
        RightToes = 20,
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
