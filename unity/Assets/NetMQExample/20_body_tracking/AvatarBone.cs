// Application 20 in Unity, one bone of an avatar: how it hangs in the T-pose, and how it turns with two landmarks.
using UnityEngine;

namespace NetMQExample
{
    /// <summary>A bone. The body's axes are x to its right, y up and z ahead, in a T-pose those of its root.</summary>
    public sealed class AvatarBone
    {
        private readonly Transform bone;
        private readonly Quaternion rest;
        private readonly Vector3 hangs;

        /// <summary>Call it in the T-pose.</summary>
        /// <param name="root">Its forward is where the avatar looks.</param>
        /// <param name="bone">The bone to turn.</param>
        /// <param name="end">The next bone, to which it points; null for one that turns with the body's axes.</param>
        public AvatarBone(Transform root, Transform bone, Transform end)
        {
            this.bone = Require.Given("bone", bone);
            var back = Quaternion.Inverse(Require.Given("root", root).rotation);
            rest = back * bone.rotation;
            if (end != null) hangs = back * (end.position - bone.position);
        }

        /// <summary>Turns it with the body alone.</summary>
        /// <param name="body">The body's axes in the world.</param>
        public void Turn(Quaternion body) => bone.rotation = body * rest;

        /// <summary>Turns it with the body, and then to where it points: so knees and feet look ahead when the person
        /// turns round.</summary>
        /// <param name="body">The body's axes in the world.</param>
        /// <param name="direction">From one landmark to the other, in the world.</param>
        public void Point(Quaternion body, Vector3 direction) => bone.rotation =
            body * Quaternion.FromToRotation(hangs, Quaternion.Inverse(body) * direction) * rest;
    }
}
