// Scripts set lines, faces, meshes and lights, which the player's cameras do not draw, and sounds, which nobody hears.
using System;
using System.Collections.Generic;

namespace UnityEngine
{
    public sealed class LineRenderer : Renderer
    {
        // Unity's new one has these two.
        private Vector3[] places = { Vector3.zero, Vector3.forward };
        public float startWidth { get; set; } = 1;
        public float endWidth { get; set; } = 1;
        public float widthMultiplier { get; set; } = 1;
        public Color startColor { get; set; } = Color.white;
        public Color endColor { get; set; } = Color.white;
        public bool useWorldSpace { get; set; } = true;
        public bool loop { get; set; }
        public int positionCount { get => places.Length; set => Array.Resize(ref places, value); }
        public Vector3 GetPosition(int index) => places[index];

        // As in Unity, a place beyond positionCount is an error in the log, and nothing is thrown.
        public void SetPosition(int index, Vector3 position)
        {
            MainThread.Only(nameof(SetPosition));
            if (index >= 0 && index < places.Length) places[index] = position;
            else Debug.LogError(
                $"LineRenderer.SetPosition index out of bounds! ({index}, positionCount is {places.Length})");
        }

        public void SetPositions(Vector3[] positions)
        {
            MainThread.Only(nameof(SetPositions));
            Array.Copy(positions, places, Math.Min(positions.Length, places.Length));
        }
    }

    public class SkinnedMeshRenderer : Renderer
    {
        private readonly Dictionary<int, float> weights = new Dictionary<int, float>();
        public float GetBlendShapeWeight(int index) => weights.TryGetValue(index, out var weight) ? weight : 0;
        public void SetBlendShapeWeight(int index, float value) => weights[index] = value;
    }

    public sealed class Light : Behaviour
    {
        public float intensity { get; set; } = 1;
        public Color color { get; set; } = Color.white;
    }

    public sealed class Mesh : Object
    {
        public Vector3[] vertices { get; set; } = new Vector3[0];
        public Vector3[] normals { get; set; } = new Vector3[0];
        public Vector2[] uv { get; set; } = new Vector2[0];
        public int[] triangles { get; set; } = new int[0];
        public int vertexCount => vertices.Length;
        public void Clear() => (vertices, normals, uv, triangles) = (new Vector3[0], normals, uv, new int[0]);
        public void RecalculateNormals() => MainThread.Only(nameof(RecalculateNormals));
        public void RecalculateBounds() => MainThread.Only(nameof(RecalculateBounds));
    }

    public sealed class MeshFilter : Component
    {
        public Mesh mesh { get; set; } = new Mesh();
    }

    public sealed class AudioClip : Object
    {
        private AudioClip() { }
        public int samples { get; private set; }
        public static AudioClip Create(string name, int lengthSamples, int channels, int frequency, bool stream) =>
            new AudioClip { name = name, samples = lengthSamples };
    }

    // A clip never ends by itself here.
    public sealed class AudioSource : Behaviour
    {
        public AudioClip clip { get; set; }
        public float volume { get; set; } = 1;
        public float pitch { get; set; } = 1;
        public bool loop { get; set; }
        public bool isPlaying { get; private set; }
        public void Play() => isPlaying = MainThread.Of(nameof(Play), clip != null);
        public void PlayOneShot(AudioClip clip) => MainThread.Only(nameof(PlayOneShot));
        public void Stop() => isPlaying = false;
    }

    public sealed class Gizmos
    {
        public static Color color { get; set; } = Color.white;
        public static void DrawLine(Vector3 from, Vector3 to) { }
        public static void DrawRay(Vector3 from, Vector3 direction) { }
        public static void DrawWireSphere(Vector3 center, float radius) { }
    }
}
