// Application 20 in Unity: a person turns the bones of a humanoid, such as any character of the Asset Store or Mixamo.
//
// Use: add it to an object that has a BodyTracker, and drag the character into its field. The character's *Rig* must be
// *Humanoid*, and it must stand in its T-pose when play begins.
using System.Linq;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Turns hips, spine, head, arms, legs and feet. The character stays where it is.</summary>
    [AddComponentMenu("NetMQ Example/20 Pose Avatar")]
    [RequireComponent(typeof(BodyTracker))]
    public sealed class PoseAvatar : MonoBehaviour
    {
        [SerializeField, Tooltip("The character; its Rig must be Humanoid")] private Animator character;

        private static readonly HumanBodyBones[] Trunk =
            { HumanBodyBones.Hips, HumanBodyBones.Spine, HumanBodyBones.Head };
        private BodyTracker tracker;
        private AvatarBone[] trunk, limbs;

        private void Start()
        {
            tracker = GetComponent<BodyTracker>();
            Transform Find(HumanBodyBones bone) => character.GetBoneTransform(bone);
            var human = character != null && character.isHuman && Find(HumanBodyBones.Hips) != null;
            enabled = human && !tracker.IsHand;
            if (character == null && Application.isEditor) Debug.Log("PoseAvatar: drag a character into its field");
            if (character != null && tracker.IsHand)
                Debug.LogWarning("an avatar needs a person: leave the field Hand of BodyTracker empty");
            if (character != null && !human)
                Debug.LogError(character.name + (character.isHuman
                    ? " has no bones in the scene: in its import settings untick Rig, Optimize Game Objects"
                    : " is no humanoid: in its import settings choose Rig, Humanoid"));
            if (!enabled) return;
            trunk = Trunk.Select(bone => new AvatarBone(character.transform, Find(bone), null)).ToArray();
            // Toes are optional: feet without them turn with the leg.
            limbs = AvatarLimbs.All.Select(limb => Find(limb.End) == null
                ? null : new AvatarBone(character.transform, Find(limb.Bone), Find(limb.End))).ToArray();
        }

        // After the Animator, whose own pose it overwrites. From the hips outwards: a bone carries those behind it.
        private void LateUpdate()
        {
            if (!tracker.Present) return;
            var root = character.transform.rotation;
            Quaternion hips = root * AvatarLimbs.Hips(tracker), chest = root * AvatarLimbs.Chest(tracker);
            trunk[0].Turn(hips);
            trunk[1].Turn(chest);
            trunk[2].Turn(root * AvatarLimbs.Head(tracker));
            for (var i = 0; i < limbs.Length; i++)
            {
                var (_, _, from, to, arm) = AvatarLimbs.All[i];
                limbs[i]?.Point(arm ? chest : hips, root * (tracker.Place(to) - tracker.Place(from)));
            }
        }
    }
}
