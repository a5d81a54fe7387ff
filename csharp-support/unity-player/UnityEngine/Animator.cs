// A character: which of its parts is which bone of a human. The player has no models, so a test says it. Nor has it
// states that move it: parameters only keep what a script sets.
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
        private readonly Dictionary<int, float> parameters = new Dictionary<int, float>();
        public bool isHuman => Bones.Count > 0;
        public void Play(string stateName) => MainThread.Only(nameof(Play));
        public void Play(string stateName, int layer) => Play(stateName);
        public static int StringToHash(string name) => name.GetHashCode();
        public void SetTrigger(string name) => SetTrigger(StringToHash(name));
        public void SetTrigger(int id) => SetFloat(id, 1);
        public void ResetTrigger(string name) => ResetTrigger(StringToHash(name));
        public void ResetTrigger(int id) => SetFloat(id, 0);
        public bool GetBool(string name) => GetBool(StringToHash(name));
        public bool GetBool(int id) => GetFloat(id) != 0;
        public void SetBool(string name, bool value) => SetBool(StringToHash(name), value);
        public void SetBool(int id, bool value) => SetFloat(id, value ? 1 : 0);
        public int GetInteger(string name) => GetInteger(StringToHash(name));
        public int GetInteger(int id) => (int)GetFloat(id);
        public void SetInteger(string name, int value) => SetInteger(StringToHash(name), value);
        public void SetInteger(int id, int value) => SetFloat(id, value);
        public float GetFloat(string name) => GetFloat(StringToHash(name));
        public float GetFloat(int id) => parameters.TryGetValue(id, out var value) ? value : 0;
        public void SetFloat(string name, float value) => SetFloat(StringToHash(name), value);
        public void SetFloat(int id, float value) => parameters[id] = value;

        /// <summary>Null for a bone that this character does not have.</summary>
        public Transform GetBoneTransform(HumanBodyBones humanBoneId)
        {
            MainThread.Only(nameof(GetBoneTransform));
            return Bones.TryGetValue(humanBoneId, out var bone) ? bone : null;
        }
    }
}
