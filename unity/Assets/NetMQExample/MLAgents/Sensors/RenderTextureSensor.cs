// ML-Agents' shape, a render texture as a sensor: somebody else draws it.
using UnityEngine;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>The picture in a render texture.</summary>
    public class RenderTextureSensor : PictureSensor
    {
        private readonly RenderTexture texture;

        /// <summary>With its texture.</summary>
        public RenderTextureSensor(
            RenderTexture renderTexture, bool grayscale, string name, SensorCompressionType compressionType)
            : base(name, Require.Given("renderTexture", renderTexture).width, renderTexture.height, grayscale,
                ObservationType.Default)
        {
            texture = renderTexture;
            CompressionType = compressionType;
        }

        internal override void Look()
        {
            if (HasGraphics) Read(texture);
        }
    }
}
