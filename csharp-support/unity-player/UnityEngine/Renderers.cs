// Scripts set lines, faces and lights, which the player's cameras do not draw.
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
}
