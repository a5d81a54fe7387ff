// Application 20 in Unity, which bones of a humanoid go with which landmarks, and where the trunk looks.
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Bones and landmarks.</summary>
    public static class AvatarLimbs
    {
        /// <summary>Each bone points from its own joint to the next one's, as the landmarks do; parents come first.
        /// </summary>
        public static readonly (HumanBodyBones Bone, HumanBodyBones End, int From, int To, bool Arm)[] All =
        {
            (HumanBodyBones.LeftUpperArm, HumanBodyBones.LeftLowerArm, 11, 13, true),
            (HumanBodyBones.LeftLowerArm, HumanBodyBones.LeftHand, 13, 15, true),
            (HumanBodyBones.RightUpperArm, HumanBodyBones.RightLowerArm, 12, 14, true),
            (HumanBodyBones.RightLowerArm, HumanBodyBones.RightHand, 14, 16, true),
            (HumanBodyBones.LeftUpperLeg, HumanBodyBones.LeftLowerLeg, 23, 25, false),
            (HumanBodyBones.LeftLowerLeg, HumanBodyBones.LeftFoot, 25, 27, false),
            (HumanBodyBones.LeftFoot, HumanBodyBones.LeftToes, 27, 31, false),
            (HumanBodyBones.RightUpperLeg, HumanBodyBones.RightLowerLeg, 24, 26, false),
            (HumanBodyBones.RightLowerLeg, HumanBodyBones.RightFoot, 26, 28, false),
            (HumanBodyBones.RightFoot, HumanBodyBones.RightToes, 28, 32, false),
        };

        public static Quaternion Hips(BodyTracker body) => Axes(body.Place(24) - body.Place(23), Spine(body));
        public static Quaternion Chest(BodyTracker body) => Axes(body.Place(12) - body.Place(11), Spine(body));

        /// <summary>Where the face looks: from between the ears to the middle of nose and eyes, which is as high.
        /// </summary>
        public static Quaternion Head(BodyTracker body)
        {
            var right = body.Place(8) - body.Place(7);
            var face = (body.Place(0) + body.Place(2) + body.Place(5)) / 3;
            return Axes(right, Vector3.Cross(face - (body.Place(7) + body.Place(8)) / 2, right));
        }

        private static Vector3 Spine(BodyTracker body) =>
            body.Place(11) + body.Place(12) - body.Place(23) - body.Place(24);

        // In Unity's axes, to the right times up is ahead.
        private static Quaternion Axes(Vector3 right, Vector3 up)
        {
            var ahead = Vector3.Cross(right, up);
            return ahead == Vector3.zero ? Quaternion.identity : Quaternion.LookRotation(ahead, up);
        }
    }

    /// <summary>A bone. The body's axes are x to its right, y up and z ahead, in a T-pose those of its root.</summary>
    public sealed class AvatarBone
    {
        private readonly Transform bone;
        private readonly Quaternion rest;
        private readonly Vector3 hangs;

        /// <summary>Call it in the T-pose.</summary>
        /// <param name="root">Its forward is where the avatar looks.</param>
        /// <param name="end">The next bone, to which it points; null for one that turns with the body's axes.</param>
        public AvatarBone(Transform root, Transform bone, Transform end)
        {
            this.bone = Require.Given("bone", bone);
            var back = Quaternion.Inverse(Require.Given("root", root).rotation);
            rest = back * bone.rotation;
            if (end != null) hangs = back * (end.position - bone.position);
        }

        /// <summary>Turns it with the body alone.</summary>
        public void Turn(Quaternion body) => bone.rotation = body * rest;

        /// <summary>Turns it with the body, and then to where it points: so knees and feet look ahead when the person
        /// turns round.</summary>
        public void Point(Quaternion body, Vector3 direction) => bone.rotation =
            body * Quaternion.FromToRotation(hangs, Quaternion.Inverse(body) * direction) * rest;
    }
}
