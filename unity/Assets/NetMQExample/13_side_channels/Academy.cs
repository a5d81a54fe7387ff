// Lesson 13, where a scene finds its parameters and statistics: under the names that ML-Agents has for them.
//
// The folder MLAgents has its other half, which asks Python in each step of ML-Agents' agents; a game without that
// folder needs none of it.
using System;
using NetMQExample.MLAgents.SideChannels;

namespace NetMQExample.MLAgents
{
    /// <summary>The channels that every scene has, and the steps of its agents.</summary>
    public sealed partial class Academy : IDisposable
    {
        private static Academy instance;

        private EngineConfigurationChannel engine;
        // Whether a component of this lesson brings the channels to Python, and no agents of ML-Agents' shape.
        private bool Carried { get; set; }

        private Academy() { }

        /// <summary>The one of this Play. There always is one.</summary>
        public static Academy Instance
        {
            get
            {
                if (instance != null) return instance;
                // Set before it awakes: what awakes with it may ask for it.
                var made = instance = new Academy();
                try { made.Awaken(); }
                catch
                {
                    // Such as in a constructor, or on another thread: Unity allows nothing there.
                    instance = null;
                    throw;
                }
                return made;
            }
        }

        /// <summary>Whether anybody has asked for it: a script of ML-Agents looks before it unregisters a
        /// channel.</summary>
        public static bool IsInitialized => instance != null;

        /// <summary>The parameters that Python has set for the scene.</summary>
        public EnvironmentParameters EnvironmentParameters { get; } = new EnvironmentParameters();

        /// <summary>The recorder of the scene for Python's statistics.</summary>
        public StatsRecorder StatsRecorder { get; } = new StatsRecorder();

        /// <summary>Registers its channels, unless they are, for a component of yours that brings them to Python.
        /// Python's wishes for the engine are applied.</summary>
        public void Begin(Action<ConfigurationType, double[]> apply)
        {
            Carried = true;
            Register(apply);
        }

        /// <summary>As early in 2020, before there was SideChannelManager.</summary>
        public void RegisterSideChannel(SideChannel channel) => SideChannelManager.RegisterSideChannel(channel);

        public void UnregisterSideChannel(SideChannel channel) => SideChannelManager.UnregisterSideChannel(channel);

        /// <summary>Unregisters its channels; the next Play has another academy.</summary>
        public void Dispose()
        {
            SideChannelManager.UnregisterSideChannel(engine);
            SideChannelManager.UnregisterSideChannel(EnvironmentParameters);
            SideChannelManager.UnregisterSideChannel(StatsRecorder);
            if (instance == this) instance = null;
            Sleep();
        }

        partial void Awaken();

        partial void Sleep();

        private void Register(Action<ConfigurationType, double[]> apply)
        {
            if (engine != null) return;
            engine = new EngineConfigurationChannel(apply);
            SideChannelManager.RegisterSideChannel(engine);
            SideChannelManager.RegisterSideChannel(EnvironmentParameters);
            SideChannelManager.RegisterSideChannel(StatsRecorder);
        }
    }
}
