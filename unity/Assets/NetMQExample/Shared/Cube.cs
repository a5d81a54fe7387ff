// Cubes and other shapes for the lessons' scenes. They are made when play begins, because a material that a scene file
// can name belongs to one render pipeline, and is magenta in the others.
//
// Use: Cube.Make(size, colour, parent) in a script makes a cube, with its size in metres, and returns its transform. As
// a component it is on what moves in the scenes of lessons 03, 07 and 21. An object of your own has its own shape.
using System.Collections.Generic;
using UnityEngine;
using UnityEngine.Rendering;

namespace NetMQExample
{
    /// <summary>Shows where its object is.</summary>
    [AddComponentMenu("NetMQ Example/Cube")]
    public sealed class Cube : MonoBehaviour
    {
        // One material for all that has this colour: Unity draws them together, and no scene leaves any behind.
        private static readonly Dictionary<Color32, Material> Paints = new Dictionary<Color32, Material>();

        /// <summary>Makes a cube.</summary>
        /// <param name="size">In metres.</param>
        /// <param name="colour">Of all sides; none: white.</param>
        public static Transform Make(Vector3 size, Color32? colour = null, Transform parent = null)
        {
            var cube = Shape(PrimitiveType.Cube, colour, parent);
            cube.localScale = size;
            return cube;
        }

        /// <summary>Makes any of Unity's shapes.</summary>
        /// <param name="colour">Of all sides; none: white.</param>
        public static Transform Shape(PrimitiveType type, Color32? colour = null, Transform parent = null)
        {
            var shape = GameObject.CreatePrimitive(type).transform;
            shape.SetParent(parent, false);
            var renderer = shape.GetComponent<Renderer>();
            var paint = colour ?? new Color32(255, 255, 255, 255);
            // Unity ends a material with the Play, and may keep the statics.
            if (!Paints.TryGetValue(paint, out var made) || made == null) Paints[paint] = made = Blank(renderer);
            made.color = paint;
            renderer.sharedMaterial = made;
            return shape;
        }

        private void Awake() => Make(Vector3.one, null, transform);

        // In the editor a new shape has its pipeline's own material. In a build it has that of the built-in pipeline,
        // which no other can draw.
        private static Material Blank(Renderer renderer)
        {
            if (Application.isEditor || GraphicsSettings.currentRenderPipeline == null)
                return new Material(renderer.sharedMaterial);
            // A game that has anything lit by URP has this; every game has the other, which knows no light.
            var lit = Shader.Find("Universal Render Pipeline/Lit");
            return new Material(lit != null ? lit : Shader.Find("Sprites/Default"));
        }
    }
}
