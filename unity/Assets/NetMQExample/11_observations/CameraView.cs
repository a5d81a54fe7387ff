// Lesson 11 in Unity, a view: what a camera sees now, as an array for Python, the highest row first.
//
//     using var view = new CameraView(camera, 84, 84, greyscale: true);
//     MessageArray picture = view.Look();                      uint8 [84, 84]; in colour uint8 [84, 84, 3]
//
// Take home: this file and CameraReadback.cs (lesson 08), with Message.cs (lesson 05).
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
        private readonly byte[] pixels;
        private readonly int width, height;
        private readonly bool greyscale;

        /// <summary>Takes the camera: it gets a texture of its own.</summary>
        /// <exception cref="ArgumentException">There is no graphics card.</exception>
        public CameraView(Camera camera, int width, int height, bool greyscale)
        {
            (this.camera, this.width, this.height, this.greyscale) = (camera, width, height, greyscale);
            camera.enabled = false;
            camera.targetTexture = new RenderTexture(
                width, height, 24, RenderTextureFormat.ARGB32, RenderTextureReadWrite.sRGB);
            pixels = new byte[width * height * 4];
            readback = new CameraReadback(camera, pixels);
            readback.Turned = readback.IsTurned();
        }

        /// <summary>What it sees now.</summary>
        /// <exception cref="MessageException">The graphics card gave no picture.</exception>
        public MessageArray Look()
        {
            readback.Begin();
            readback.Wait();
            if (readback.Failed) throw new MessageException("no-picture", "the graphics card gave no picture");
            return greyscale ? Grey() : Coloured();
        }

        /// <summary>Releases the texture.</summary>
        public void Dispose()
        {
            if (camera == null) return;
            Object.Destroy(camera.targetTexture);
            camera.targetTexture = null;
        }

        private MessageArray Coloured()
        {
            var picture = new byte[width * height * 3];
            for (var i = 0; i < picture.Length; i++) picture[i] = pixels[4 * Upright(i / 3) + i % 3];
            return new MessageArray("uint8", picture, height, width, 3);
        }

        // As television weighs colours: 0.299 red, 0.587 green, 0.114 blue.
        private MessageArray Grey()
        {
            var picture = new byte[width * height];
            for (var i = 0; i < picture.Length; i++)
            {
                var at = 4 * Upright(i);
                picture[i] = (byte)((299 * pixels[at] + 587 * pixels[at + 1] + 114 * pixels[at + 2] + 500) / 1000);
            }
            return new MessageArray("uint8", picture, height, width);
        }

        // What comes from the graphics card has the lowest row first.
        private int Upright(int pixel) => (height - 1 - pixel / width) * width + pixel % width;
    }
}
