// Lesson 13, where a scene finds its parameters and statistics: under the names that ML-Agents has for them.
using System;
using NetMQExample.MLAgents.SideChannels;

namespace NetMQExample.MLAgents
{
    /// <summary>The channels that every scene has.</summary>
    public sealed class Academy : IDisposable
    {
        private EngineConfigurationChannel engine;

        private Academy() { }

        /// <summary>The one of this Play. There always is one.</summary>
        public static Academy Instance { get; private set; } = new Academy();

        /// <summary>True: a script of ML-Agents asks before it unregisters a channel.</summary>
        public static bool IsInitialized => true;

        /// <summary>The parameters that Python has set for the scene.</summary>
        public EnvironmentParameters EnvironmentParameters { get; } = new EnvironmentParameters();

        /// <summary>The recorder of the scene for Python's statistics.</summary>
        public StatsRecorder StatsRecorder { get; } = new StatsRecorder();

        /// <summary>Registers its channels, unless they are. Python's wishes for the engine are applied.</summary>
        public void Begin(Action<ConfigurationType, double[]> apply)
        {
            if (engine != null) return;
            engine = new EngineConfigurationChannel(apply);
            SideChannelManager.RegisterSideChannel(engine);
            SideChannelManager.RegisterSideChannel(EnvironmentParameters);
            SideChannelManager.RegisterSideChannel(StatsRecorder);
        }

        /// <summary>As early in 2020, before there was SideChannelManager.</summary>
        public void RegisterSideChannel(SideChannel channel) => SideChannelManager.RegisterSideChannel(channel);

        /// <summary>As early in 2020.</summary>
        public void UnregisterSideChannel(SideChannel channel) => SideChannelManager.UnregisterSideChannel(channel);

        /// <summary>Unregisters its channels; the next Play has another academy.</summary>
        public void Dispose()
        {
            SideChannelManager.UnregisterSideChannel(engine);
            SideChannelManager.UnregisterSideChannel(EnvironmentParameters);
            SideChannelManager.UnregisterSideChannel(StatsRecorder);
            if (Instance == this) Instance = new Academy();
        }
    }
}
