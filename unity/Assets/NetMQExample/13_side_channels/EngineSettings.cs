// Lesson 13 in Unity, what becomes of engine settings that come: the same as in ML-Agents.
//
// Use: SideChannelBehaviour.cs gives it to the academy.
using UnityEngine;

namespace NetMQExample.MLAgents.SideChannels
{
    /// <summary>Sets what EngineConfigurationChannel hears of. On the main thread.</summary>
    public static class EngineSettings
    {
        /// <summary>Sets it, and logs it.</summary>
        public static void Apply(ConfigurationType kind, double[] values)
        {
            Debug.Log(EngineConfigurationChannel.Describe(kind, values));
            var value = (int)values[0];
            if (kind == ConfigurationType.ScreenResolution) Screen.SetResolution(value, (int)values[1], false);
            if (kind == ConfigurationType.QualityLevel) QualitySettings.SetQualityLevel(value, true);
            if (kind == ConfigurationType.TimeScale) Time.timeScale = (float)values[0];
            if (kind == ConfigurationType.TargetFrameRate) Application.targetFrameRate = value;
            if (kind == ConfigurationType.CaptureFrameRate) Time.captureFramerate = value;
        }
    }
}
