// Lesson 08 in Unity: builds the road and the ground of cubes when play begins, in the colours of DrawnCamera.cs.
//
// Use: it stands in the lesson's scene. A scene of your own needs none.
using UnityEngine;

namespace NetMQExample
{
    /// <summary>The world around the car. On the ground y is 0.</summary>
    [AddComponentMenu("NetMQ Example/08 Road Scene")]
    public sealed class RoadScene : MonoBehaviour
    {
        // So many points of the road for each piece: 1.5 m.
        private const int Step = 10;

        private void Start()
        {
            var points = new Road().Points;
            Color32 grass = new Color32(70, 120, 50, 255), tarmac = new Color32(90, 90, 95, 255);
            var white = new Color32(230, 230, 225, 255);
            Put(new Vector3(60, 0, 45), Quaternion.identity, new Vector3(400, 1, 400), grass);
            for (var i = 0; i < points.Length; i += Step)
            {
                var (from, to) = (points[i], points[(i + Step) % points.Length]);
                var ahead = new Vector3((float)(to.X - from.X), 0, (float)(to.Y - from.Y));
                var middle = new Vector3((float)(from.X + to.X) / 2, 0, (float)(from.Y + to.Y) / 2);
                var turn = Quaternion.LookRotation(ahead);
                // One above the other: the lower ones are longer, so that no grass is seen in a bend.
                void Strip(float top, float width, float longer, Color32 colour) => Put(
                    middle + Vector3.up * top, turn, new Vector3(width, 0.002f, ahead.magnitude + longer), colour);
                Strip(0.01f, 2 * (float)Road.HalfWidth, 0.6f, white);
                Strip(0.02f, 2 * (float)Road.HalfWidth - 0.4f, 0.8f, tarmac);
                if (i % 50 < 25) Strip(0.03f, 0.2f, 0, white);
            }
        }

        // `middle` is that of the upper side.
        private static void Put(Vector3 middle, Quaternion turn, Vector3 size, Color32 colour) =>
            Cube.Make(size, colour).SetPositionAndRotation(middle - Vector3.up * (size.y / 2), turn);
    }
}
