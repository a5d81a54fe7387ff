// Renders as a graphics card would, but with flat colours: cubes in perspective, the nearer one in front.
using System;

namespace UnityEngine
{
    internal sealed class Rasterizer
    {
        // A face that is cut by the plane in front of the camera has one corner more than four.
        private readonly Vector3[] corners = new Vector3[4], cut = new Vector3[6];
        private readonly double[] across = new double[6], up = new double[6];
        private int[] colours = new int[0];
        // One divided by how far ahead it is: that is straight on the screen.
        private float[] nearness = new float[0];
        private int width, height;
        private double focal;

        public void Draw(Camera camera, RenderTexture target)
        {
            (width, height) = (target.width, target.height);
            focal = height / 2.0 / Math.Tan(camera.fieldOfView * Math.PI / 360);
            if (colours.Length != width * height)
                (colours, nearness) = (new int[width * height], new float[width * height]);
            Array.Fill(colours, Packed(camera.backgroundColor));
            Array.Clear(nearness, 0, nearness.Length);
            var (eye, back) = (camera.transform.position, camera.transform.rotation.Back);
            for (var i = 0; i < LoadedScene.Objects.Count; i++)
            {
                var thing = LoadedScene.Objects[i];
                if (!thing.activeInHierarchy || !(thing.GetComponent<Renderer>() is Renderer shape) || !shape.enabled
                    || (camera.cullingMask >> thing.layer & 1) == 0) continue;
                var (turn, half) = (back * thing.transform.rotation, thing.transform.lossyScale * 0.5f);
                Cube(back * (thing.transform.position - eye), turn * new Vector3(half.x, 0, 0),
                    turn * new Vector3(0, half.y, 0),
                    turn * new Vector3(0, 0, half.z), camera, Packed(shape.sharedMaterial.color));
            }
            // Row by row, as the card has it.
            for (var row = 0; row < height; row++)
                Buffer.BlockCopy(colours, row * width * 4, target.Pixels,
                    (SystemInfo.TopRowFirst ? height - 1 - row : row) * width * 4, width * 4);
        }

        private static int Packed(Color color) =>
            Color32.Byte(color.r) | Color32.Byte(color.g) << 8 | Color32.Byte(color.b) << 16 | 255 << 24;

        // All as the camera sees it: x to the right, y up, z ahead.
        private void Cube(Vector3 middle, Vector3 a, Vector3 b, Vector3 c, Camera camera, int colour)
        {
            var reach = Math.Sqrt(a.sqrMagnitude + b.sqrMagnitude + c.sqrMagnitude);
            if (middle.z + reach < camera.nearClipPlane || middle.z - reach > camera.farClipPlane) return;
            double wide = width / 2.0, high = height / 2.0;
            if ((Math.Abs(middle.x) * focal) - (middle.z * wide) > reach * Math.Sqrt((wide * wide) + (focal * focal)))
                return;
            if ((Math.Abs(middle.y) * focal) - (middle.z * high) > reach * Math.Sqrt((high * high) + (focal * focal)))
                return;
            for (var side = -1; side <= 1; side += 2)
            {
                Face(middle, a * side, b, c, camera.nearClipPlane, colour);
                Face(middle, b * side, c, a, camera.nearClipPlane, colour);
                Face(middle, c * side, a, b, camera.nearClipPlane, colour);
            }
        }

        private void Face(Vector3 middle, Vector3 outwards, Vector3 a, Vector3 b, float near, int colour)
        {
            var centre = middle + outwards;
            var distance = Vector3.Dot(outwards, centre);
            // From behind a face is not seen.
            if (distance >= 0) return;
            (corners[0], corners[1], corners[2], corners[3]) = (centre - a - b, centre - a + b, centre + a + b,
                centre + a - b);
            var count = 0;
            for (var i = 0; i < 4; i++)
            {
                var (from, to) = (corners[i], corners[(i + 1) % 4]);
                if (from.z >= near) cut[count++] = from;
                if (from.z >= near != to.z >= near)
                    cut[count++] = from + ((to - from) * ((near - from.z) / (to.z - from.z)));
            }
            double lowest = height, highest = 0;
            for (var i = 0; i < count; i++)
            {
                across[i] = (width / 2.0) + (cut[i].x / cut[i].z * focal);
                up[i] = (height / 2.0) + (cut[i].y / cut[i].z * focal);
                (lowest, highest) = (Math.Min(lowest, up[i]), Math.Max(highest, up[i]));
            }
            // The points of the plane have outwards * point = distance; divided by z this gives the nearness of a
            // pixel.
            double perPixel = outwards.x / focal / distance, perRow = outwards.y / focal / distance;
            var first = (outwards.z / distance) - (perPixel * (width - 1) / 2.0) - (perRow * (height - 1) / 2.0);
            for (var row = Math.Max(0, (int)Math.Ceiling(lowest - 0.5)); row < height && row + 0.5 < highest; row++)
                Row(row, count, first + (perRow * row), perPixel, colour);
        }

        private void Row(int row, int count, double begin, double perPixel, int colour)
        {
            double left = width, right = 0, y = row + 0.5;
            for (int i = 0, k = count - 1; i < count; k = i++)
            {
                if (up[i] <= y == up[k] <= y) continue;
                var x = across[i] + ((across[k] - across[i]) * ((y - up[i]) / (up[k] - up[i])));
                (left, right) = (Math.Min(left, x), Math.Max(right, x));
            }
            var from = Math.Max(0, (int)Math.Ceiling(left - 0.5));
            float near = (float)(begin + (perPixel * from)), step = (float)perPixel;
            for (int x = from, at = (row * width) + from; x < width && x + 0.5 < right; x++, at++, near += step)
            {
                if (near <= nearness[at]) continue;
                nearness[at] = near;
                colours[at] = colour;
            }
        }
    }
}
