// Lesson 11 in Unity, a view: what a camera sees now, as an array for Python, the highest row first.
//
//     using var view = new CameraView(camera, 84, 84, greyscale: true);
//     MessageArray picture = view.Observe();                      uint8 [84, 84]; in colour uint8 [84, 84, 3]
using System;
using UnityEngine;
using Object = UnityEngine.Object;

namespace NetMQExample
{
    /// <summary>Has a camera look when it is asked to. For the main thread, which waits for it.</summary>
    public sealed class CameraView : IDisposable
    {
        private readonly Camera camera;
        private readonly CameraReadback readback;
        private readonly RenderTexture texture;
        private readonly byte[] pixels;
        private readonly int[] shape;

        /// <summary>Takes the camera: it gets a texture of its own.</summary>
        /// <exception cref="ArgumentException">There is no graphics card.</exception>
        public CameraView(Camera camera, int width, int height, bool greyscale)
        {
            this.camera = Require.Given("camera", camera);
            pixels = new byte[width * height * 4];
            // Before the texture: it says if there is no graphics card.
            readback = new CameraReadback(camera, pixels);
            camera.enabled = false;
            camera.targetTexture = texture = new RenderTexture(
                width, height, 24, RenderTextureFormat.ARGB32, RenderTextureReadWrite.sRGB);
            // Python has the highest row first.
            readback.Turned = !readback.IsTurned();
            shape = greyscale ? new[] { height, width } : new[] { height, width, 3 };
            Size = width * height * (greyscale ? 1 : 3);
        }

        public int Size { get; }

        /// <summary>The camera's picture of this moment.</summary>
        /// <param name="into">Where the picture is written, <see cref="Size"/> bytes; null: a new array, which no later
        /// look overwrites.</param>
        /// <exception cref="MessageException">The graphics card gave no picture.</exception>
        public MessageArray Observe(byte[] into = null)
        {
            // Another view may have set its own.
            camera.targetTexture = texture;
            readback.Begin();
            readback.Wait();
            if (readback.Failed) throw new MessageException("no-picture", "the graphics card gave no picture");
            into ??= new byte[Size];
            if (shape.Length == 2) Grey(into);
            else Colour(into);
            return new MessageArray("uint8", into, shape);
        }

        public void Dispose()
        {
            // The camera may have been destroyed before.
            if (camera != null) camera.targetTexture = null;
            Object.Destroy(texture);
        }

        private void Colour(byte[] picture)
        {
            for (int from = 0, to = 0; from < pixels.Length; from += 4, to += 3)
            {
                picture[to] = pixels[from];
                picture[to + 1] = pixels[from + 1];
                picture[to + 2] = pixels[from + 2];
            }
        }

        // As television weighs colours: 0.299 red, 0.587 green, 0.114 blue.
        private void Grey(byte[] picture)
        {
            for (int from = 0, to = 0; from < pixels.Length; from += 4, to++)
            {
                var sum = 299 * pixels[from] + 587 * pixels[from + 1] + 114 * pixels[from + 2];
                picture[to] = (byte)((sum + 500) / 1000);
            }
        }
    }
}
