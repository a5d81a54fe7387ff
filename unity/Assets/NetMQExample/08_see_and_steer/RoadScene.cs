// Lesson 08 in Unity: builds the road and the ground of cubes when play begins, in the colours of DrawnCamera.cs.
//
// Use: it stands in the lesson's scene. At home your own scene takes its place.
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
            Cube(new Vector3(60, 0, 45), Quaternion.identity, new Vector3(400, 1, 400), Paint(70, 120, 50));
            Material tarmac = Paint(90, 90, 95), white = Paint(230, 230, 225);
            for (var i = 0; i < points.Length; i += Step)
            {
                var (from, to) = (points[i], points[(i + Step) % points.Length]);
                var ahead = new Vector3((float)(to.X - from.X), 0, (float)(to.Y - from.Y));
                var middle = new Vector3((float)(from.X + to.X) / 2, 0, (float)(from.Y + to.Y) / 2);
                var turn = Quaternion.LookRotation(ahead);
                // One above the other: the lower ones are longer, so that no grass is seen in a bend.
                void Strip(float top, float width, float longer, Material paint) => Cube(
                    middle + Vector3.up * top, turn, new Vector3(width, 0.002f, ahead.magnitude + longer), paint);
                Strip(0.01f, 2 * (float)Road.HalfWidth, 0.6f, white);
                Strip(0.02f, 2 * (float)Road.HalfWidth - 0.4f, 0.8f, tarmac);
                if (i % 50 < 25) Strip(0.03f, 0.2f, 0, white);
            }
        }

        // `middle` is that of the upper side.
        private static void Cube(Vector3 middle, Quaternion turn, Vector3 size, Material paint)
        {
            var cube = GameObject.CreatePrimitive(PrimitiveType.Cube);
            cube.transform.SetPositionAndRotation(middle - Vector3.up * (size.y / 2), turn);
            cube.transform.localScale = size;
            cube.GetComponent<Renderer>().sharedMaterial = paint;
        }

        // One material for all that has this colour: Unity then draws them together.
        private static Material Paint(byte red, byte green, byte blue)
        {
            var sample = GameObject.CreatePrimitive(PrimitiveType.Cube);
            var paint = sample.GetComponent<Renderer>().material;
            paint.color = new Color32(red, green, blue, 255);
            Destroy(sample);
            return paint;
        }
    }
}
