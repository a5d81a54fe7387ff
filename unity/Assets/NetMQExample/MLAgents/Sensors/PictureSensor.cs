// ML-Agents' shape, pictures: the pixels of a render texture as uint8 [channels, height, width], the highest row
// first. Grey is the mean of red, green and blue, as ML-Agents' Python makes it.
using System;
using Unity.Collections;
using UnityEngine;
using UnityEngine.Rendering;
using Object = UnityEngine.Object;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>The base of the camera's and of the render texture's sensor.</summary>
    public abstract class PictureSensor : BuiltInSensor, IRow, IDisposable
    {
        private readonly byte[] pixels, picture;
        private readonly Texture2D copy;

        internal PictureSensor(string name, RenderTexture from, bool grayscale, SensorCompressionType compression,
            ObservationType type) : base(name, ObservationSpec.Visual(grayscale ? 1 : 3, from.height, from.width, type))
        {
            if (!HasGraphics)
                Debug.LogError($"{name} sees black only, for there is no graphics card: start without -nographics");
            Texture = from;
            CompressionType = compression;
            pixels = new byte[4 * from.width * from.height];
            picture = new byte[this.ObservationSize()];
            copy = new Texture2D(from.width, from.height, TextureFormat.RGBA32, false);
        }

        public SensorCompressionType CompressionType { get; set; }
        bool IRow.IsPicture => true;
        internal static bool HasGraphics => SystemInfo.graphicsDeviceType != GraphicsDeviceType.Null;
        internal RenderTexture Texture { get; }

        public override int Write(ObservationWriter writer)
        {
            Read();
            for (var i = 0; i < picture.Length; i++) writer[i] = picture[i] / 255f;
            return picture.Length;
        }

        void IRow.WriteRow(Span<byte> to)
        {
            Read();
            picture.CopyTo(to);
        }

        public virtual void Dispose() => Object.Destroy(copy);

        private void Read()
        {
            if (!HasGraphics) return;
            int width = copy.width, height = copy.height, size = width * height;
            var before = RenderTexture.active;
            RenderTexture.active = Texture;
            copy.ReadPixels(new Rect(0, 0, width, height), 0, 0, false);
            RenderTexture.active = before;
            NativeArray<byte>.Copy(copy.GetRawTextureData<byte>(), pixels);
            for (var to = 0; to < size; to++)
            {
                // Unity's lowest row is the first one.
                var at = 4 * ((height - 1 - to / width) * width + to % width);
                if (picture.Length == size)
                    picture[to] = (byte)((pixels[at] + pixels[at + 1] + pixels[at + 2] + 1) / 3);
                else
                    for (var channel = 0; channel < 3; channel++)
                        picture[channel * size + to] = pixels[at + channel];
            }
        }
    }

    /// <summary>The picture of a camera. It looks at each decision, and draws on the screen only where it did
    /// before.</summary>
    public class CameraSensor : PictureSensor
    {
        public CameraSensor(Camera camera, int width, int height, bool grayscale, string name,
            SensorCompressionType compression, ObservationType observationType = ObservationType.Default)
            : base(name, Surface(width, height), grayscale, compression, observationType) =>
            Camera = Require.Given("camera", camera);

        public Camera Camera { get; set; }

        public override void Update()
        {
            if (!HasGraphics) return;
            var (target, part) = (Camera.targetTexture, Camera.rect);
            (Camera.targetTexture, Camera.rect) = (Texture, new Rect(0, 0, 1, 1));
            Camera.Render();
            (Camera.targetTexture, Camera.rect) = (target, part);
        }

        public override void Dispose()
        {
            base.Dispose();
            Object.Destroy(Texture);
        }

        private static RenderTexture Surface(int width, int height) =>
            new RenderTexture(width, height, 24, RenderTextureFormat.ARGB32, RenderTextureReadWrite.sRGB);
    }

    /// <summary>The picture in a render texture, which somebody else draws.</summary>
    public class RenderTextureSensor : PictureSensor
    {
        public RenderTextureSensor(
            RenderTexture renderTexture, bool grayscale, string name, SensorCompressionType compressionType)
            : base(name, Require.Given("renderTexture", renderTexture), grayscale, compressionType,
                ObservationType.Default)
        { }
    }
}
