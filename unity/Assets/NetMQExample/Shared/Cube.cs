// Cubes for the lessons' scenes. They are made when play begins, because a material that a scene file can name belongs
// to one render pipeline, and is magenta in the others.
//
// Use: Cube.Make in a script; as a component it is on what moves in the scenes of lessons 03, 07 and 21. An object of
// your own has a shape of its own, and needs none.
using System.Collections.Generic;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Shows where its object is.</summary>
    [AddComponentMenu("NetMQ Example/Cube")]
    public sealed class Cube : MonoBehaviour
    {
        // One material for all that has this colour: Unity draws them together, and no scene leaves any behind.
        private static readonly Dictionary<Color32, Material> Paints = new Dictionary<Color32, Material>();

        /// <summary>Makes a grey one.</summary>
        /// <param name="size">In metres.</param>
        /// <param name="parent">What it goes along with.</param>
        public static Transform Make(Vector3 size, Transform parent = null)
        {
            var cube = GameObject.CreatePrimitive(PrimitiveType.Cube).transform;
            cube.SetParent(parent, false);
            cube.localScale = size;
            return cube;
        }

        /// <summary>Makes a coloured one.</summary>
        /// <param name="size">In metres.</param>
        /// <param name="colour">Of all sides.</param>
        /// <param name="parent">What it goes along with.</param>
        public static Transform Make(Vector3 size, Color32 colour, Transform parent = null)
        {
            var cube = Make(size, parent);
            var renderer = cube.GetComponent<Renderer>();
            // Unity ends it with the Play, and may keep the statics.
            if (!Paints.TryGetValue(colour, out var paint) || paint == null)
                Paints[colour] = paint = new Material(renderer.sharedMaterial) { color = colour };
            renderer.sharedMaterial = paint;
            return cube;
        }

        private void Awake() => Make(Vector3.one, transform);
    }
}
