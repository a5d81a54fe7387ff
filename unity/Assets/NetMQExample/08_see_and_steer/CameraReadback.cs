// Lesson 08, what a camera sees, as bytes: without a frame that waits for the graphics card.
//
//     var readback = new CameraReadback(camera, pixels);     the camera has a targetTexture, and is not enabled
//     readback.Begin();                                      it renders now: what it shows is this moment
//     if (readback.Poll() && !readback.Failed) …             in each Update; a frame or two later they are there
// All of it on Unity's main thread, in URP and in the built-in pipeline.
//
// Trouble: without AsyncGPUReadback (OpenGL ES 3.0, for one) Unity waits for each picture; with -nographics there are
// none.
using System;
using Unity.Collections;
using UnityEngine;
using UnityEngine.Rendering;
using Object = UnityEngine.Object;

namespace NetMQExample
{
    /// <summary>One picture of a camera on its way from the graphics card.</summary>
    public sealed class CameraReadback
    {
        // For systems on which Unity waits for each picture. All cameras share it, since its pixels are copied at once.
        private static Texture2D copy;

        private readonly Camera camera;
        private readonly byte[] pixels;
        private AsyncGPUReadbackRequest request;
        private bool waits;

        /// <param name="camera">It has a target texture; see CarCamera.cs.</param>
        /// <param name="pixels">Room for 4 bytes a pixel: red, green, blue and alpha, the lowest row first.</param>
        /// <exception cref="ArgumentException">There is no graphics card.</exception>
        public CameraReadback(Camera camera, byte[] pixels)
        {
            if (SystemInfo.graphicsDeviceType == GraphicsDeviceType.Null)
                throw new ArgumentException("a camera needs a graphics card: start Unity without -nographics");
            this.camera = Require.Given("camera", camera);
            this.pixels = Require.Given("pixels", pixels);
        }

        /// <summary>Whether each picture is turned over. <see cref="IsTurned"/> makes the lowest row the
        /// first one; the opposite, the highest.</summary>
        public bool Turned { get; set; }

        /// <summary>True if the graphics card had an error in place of the last picture.</summary>
        public bool Failed { get; private set; }

        /// <summary>Renders, and asks for the picture.</summary>
        public void Begin()
        {
            camera.Render();
            waits = SystemInfo.supportsAsyncGPUReadback;
            Failed = false;
            // Red, green, blue, alpha is what the texture holds: nothing has to be converted.
            if (waits) request = AsyncGPUReadback.Request(camera.targetTexture, 0, TextureFormat.RGBA32);
            else Read();
        }

        /// <summary>Takes the picture when it is there. Call it in each frame: in the one after, Unity has taken it
        /// back.</summary>
        /// <returns>True once it is there, or an error.</returns>
        public bool Poll()
        {
            if (!waits) return true;
            if (!request.done) return false;
            waits = false;
            Failed = request.hasError;
            if (!Failed) Copy(request.GetData<byte>());
            return true;
        }

        /// <summary>Waits for the picture, and the main thread with it: for lock-step.</summary>
        public void Wait()
        {
            if (waits) request.WaitForCompletion();
            Poll();
        }

        /// <summary>Whether the highest row comes first. That depends on the graphics card, the pipeline and its
        /// effects, so it looks twice, once with a cube in the upper half: where do the two pictures differ?</summary>
        public bool IsTurned()
        {
            var without = Now();
            var marker = GameObject.CreatePrimitive(PrimitiveType.Cube);
            var (eye, turn) = (camera.transform.position, camera.transform.rotation);
            var near = 2 * camera.nearClipPlane;
            marker.transform.SetPositionAndRotation(eye + turn * new Vector3(0, near / 2, near * 1.5f), turn);
            marker.transform.localScale = new Vector3(4, 0.5f, 1) * near;
            // On the first layer that this camera sees.
            for (var layer = 31; layer >= 0; layer--)
                if ((camera.cullingMask >> layer & 1) == 1) marker.layer = layer;
            // A copy, which nobody else would destroy.
            var paint = marker.GetComponent<Renderer>().material;
            paint.color = new Color(1, 0, 1, 1);
            var with = Now();
            Object.DestroyImmediate(marker);
            Object.DestroyImmediate(paint);
            // How much, and not how often: effects may change every pixel a little.
            var first = 0L;
            var last = 0L;
            var half = pixels.Length / 2;
            for (var i = 0; i < half; i++)
            {
                first += Math.Abs(with[i] - without[i]);
                last += Math.Abs(with[half + i] - without[half + i]);
            }
            return first > last;
        }

        private byte[] Now()
        {
            Begin();
            Wait();
            return (byte[])pixels.Clone();
        }

        private void Read()
        {
            var seen = camera.targetTexture;
            var before = RenderTexture.active;
            if (copy == null || copy.width != seen.width || copy.height != seen.height)
            {
                Object.Destroy(copy);
                copy = new Texture2D(seen.width, seen.height, TextureFormat.RGBA32, false);
            }
            RenderTexture.active = seen;
            copy.ReadPixels(new Rect(0, 0, seen.width, seen.height), 0, 0, false);
            RenderTexture.active = before;
            Copy(copy.GetRawTextureData<byte>());
        }

        private void Copy(NativeArray<byte> data)
        {
            var row = 4 * camera.targetTexture.width;
            if (!Turned) NativeArray<byte>.Copy(data, pixels);
            else
                for (var at = 0; at < pixels.Length; at += row)
                    NativeArray<byte>.Copy(data, at, pixels, pixels.Length - row - at, row);
        }
    }
}
