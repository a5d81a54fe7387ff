// ML-Agents' shape, a picture: the pixels of a render texture as uint8 [channels, height, width], the highest row
// first. Grey is the mean of red, green and blue, as ML-Agents' Python makes it.
using System;
using Unity.Collections;
using UnityEngine;
using UnityEngine.Rendering;
using Object = UnityEngine.Object;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>The base of the camera's and of the render texture's sensor.</summary>
    public abstract class PictureSensor : BuiltInSensor, IPicture, IDisposable
    {
        private readonly int width, height, channels;
        private readonly byte[] pixels, picture;
        private readonly Texture2D copy;

        internal PictureSensor(string name, int width, int height, bool grayscale, ObservationType type)
            : base(name, ObservationSpec.Visual(grayscale ? 1 : 3, height, width, type))
        {
            if (!HasGraphics)
                Debug.LogError($"{name} sees black only, for there is no graphics card: start without -nographics");
            this.width = width;
            this.height = height;
            channels = grayscale ? 1 : 3;
            pixels = new byte[4 * width * height];
            picture = new byte[channels * width * height];
            copy = new Texture2D(width, height, TextureFormat.RGBA32, false);
        }

        /// <summary>Nothing here depends on it: pictures are sent as they are.</summary>
        public SensorCompressionType CompressionType { get; set; }

        bool IPicture.IsPicture => true;

        internal static bool HasGraphics => SystemInfo.graphicsDeviceType != GraphicsDeviceType.Null;

        /// <inheritdoc/>
        public override int Write(ObservationWriter writer)
        {
            Look();
            for (var i = 0; i < picture.Length; i++) writer[i] = picture[i] / 255f;
            return picture.Length;
        }

        void IPicture.Write(Span<byte> to)
        {
            Look();
            picture.AsSpan().CopyTo(to);
        }

        /// <summary>Destroys its textures.</summary>
        public virtual void Dispose() => Object.Destroy(copy);

        // The last moment before the picture is taken.
        internal virtual void Look() { }

        internal void Read(RenderTexture from)
        {
            var before = RenderTexture.active;
            RenderTexture.active = from;
            copy.ReadPixels(new Rect(0, 0, width, height), 0, 0, false);
            RenderTexture.active = before;
            NativeArray<byte>.Copy(copy.GetRawTextureData<byte>(), pixels);
            var size = width * height;
            for (var y = 0; y < height; y++)
                for (var x = 0; x < width; x++)
                {
                    var at = 4 * (((height - 1 - y) * width) + x);
                    var to = (y * width) + x;
                    if (channels == 1)
                        picture[to] = (byte)((pixels[at] + pixels[at + 1] + pixels[at + 2] + 1) / 3);
                    else
                        for (var channel = 0; channel < 3; channel++)
                            picture[(channel * size) + to] = pixels[at + channel];
                }
        }
    }
}
