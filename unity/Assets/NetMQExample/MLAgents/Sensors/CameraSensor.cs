// ML-Agents' shape, a camera as a sensor. It looks at each decision, and draws on the screen only where it did before.
using UnityEngine;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>The picture of a camera.</summary>
    public class CameraSensor : PictureSensor
    {
        private readonly RenderTexture texture;

        /// <summary>With its camera, and the size of its picture.</summary>
        public CameraSensor(Camera camera, int width, int height, bool grayscale, string name,
            SensorCompressionType compression, ObservationType observationType = ObservationType.Default)
            : base(name, width, height, grayscale, observationType)
        {
            Camera = Require.Given("camera", camera);
            CompressionType = compression;
            texture = new RenderTexture(width, height, 24, RenderTextureFormat.ARGB32, RenderTextureReadWrite.sRGB);
        }

        /// <summary>The camera.</summary>
        public Camera Camera { get; set; }

        /// <inheritdoc/>
        public override void Update()
        {
            if (!HasGraphics) return;
            var target = Camera.targetTexture;
            var part = Camera.rect;
            Camera.targetTexture = texture;
            Camera.rect = new Rect(0, 0, 1, 1);
            Camera.Render();
            Read(texture);
            Camera.targetTexture = target;
            Camera.rect = part;
        }

        /// <inheritdoc/>
        public override void Dispose()
        {
            base.Dispose();
            Object.Destroy(texture);
        }
    }
}
