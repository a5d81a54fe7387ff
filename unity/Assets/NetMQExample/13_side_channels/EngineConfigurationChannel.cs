// Lesson 13, engine settings: how fast the game's time passes, and how it is drawn. From Python to Unity.
//
// One message for each setting: its number as int32, then int32 width and height, or float32 time scale, or one int32.
// The Python side is engine_configuration_channel.py, and what Unity does with them is in EngineSettings.cs.
using System;
using System.Globalization;
using System.Linq;

namespace NetMQExample.MLAgents.SideChannels
{
    /// <summary>Which setting.</summary>
    public enum ConfigurationType
    {
        ScreenResolution = 0,
        /// <summary>As in Project Settings, Quality.</summary>
        QualityLevel = 1,
        /// <summary>The only one that is no whole number.</summary>
        TimeScale = 2,
        /// <summary>Frames a second, -1 for as Unity likes.</summary>
        TargetFrameRate = 3,
        /// <summary>Frames in a second of the game's time, whatever the clock says; 0 for off.</summary>
        CaptureFrameRate = 4,
    }

    /// <summary>Hands each setting that comes to whoever can set it.</summary>
    public sealed class EngineConfigurationChannel : SideChannel
    {
        // Pixels, the largest texture of most graphics cards.
        private const int MostPixels = 16384;

        private readonly Action<ConfigurationType, double[]> apply;

        public EngineConfigurationChannel(Action<ConfigurationType, double[]> apply)
        {
            ChannelId = new Guid("e951342c-4f7e-11ea-b238-784f4387d1f7");
            this.apply = Require.Given("apply", apply);
        }

        /// <summary>A setting in words: <c>engine: time scale 2.0</c>.</summary>
        public static string Describe(ConfigurationType kind, double[] values)
        {
            var format = kind == ConfigurationType.TimeScale ? "F1" : "F0";
            var texts = values.Select(value => value.ToString(format, CultureInfo.InvariantCulture));
            return $"engine: {Name(kind)} {string.Join(" x ", texts)}";
        }

        protected override void OnMessageReceived(IncomingMessage msg)
        {
            var kind = (ConfigurationType)msg.ReadInt32();
            switch (kind)
            {
                case ConfigurationType.ScreenResolution:
                    var (width, height) = (msg.ReadInt32(), msg.ReadInt32());
                    if (Math.Min(width, height) <= 0 || Math.Max(width, height) > MostPixels)
                        throw new UnityAgentsException($"a screen of {width} x {height}");
                    apply(kind, new double[] { width, height });
                    break;
                case ConfigurationType.TimeScale:
                    var scale = msg.ReadFloat32();
                    if (float.IsNaN(scale) || float.IsInfinity(scale))
                        throw new UnityAgentsException("a time scale that is no number");
                    // As ML-Agents does in the editor: no slower than time is, and no faster than a game can follow.
                    apply(kind, new double[] { Math.Clamp(scale, 1, 100) });
                    break;
                case ConfigurationType.QualityLevel:
                case ConfigurationType.TargetFrameRate:
                case ConfigurationType.CaptureFrameRate:
                    var value = msg.ReadInt32();
                    // -1 is for as Unity likes.
                    if (value < (kind == ConfigurationType.TargetFrameRate ? -1 : 0))
                        throw new UnityAgentsException($"a {Name(kind)} of {value}");
                    apply(kind, new double[] { value });
                    break;
                default:
                    throw new UnityAgentsException(
                        $"engine settings are 0 to 4, not {(int)kind}: are both sides of one release?");
            }
        }

        private static string Name(ConfigurationType kind) => string.Concat(kind.ToString()
            .Select((c, i) => char.IsUpper(c) && i > 0 ? $" {c}" : $"{c}")).ToLowerInvariant();
    }
}
