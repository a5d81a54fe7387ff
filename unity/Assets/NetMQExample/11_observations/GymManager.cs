// Lesson 11 in Unity: what an agent sees is said where it is declared. This brings all agents of the scene to Python.
//
// Use: start python/11_observations/server.py, open this lesson's scene, press Play. For your own scene: add this
// component to any GameObject, and agents (Agent.cs) and sensors wherever they belong.
// Nothing moves while Python thinks: for each step OnTick is called, and physics is simulated for as long. What a
// script does in FixedUpdate, it does in OnTick from now on. While it is disabled, the agents play without Python.
// A scene may be loaded anew, also by an agent's OnReset: the new scene's GymManager goes on with the connection.
using UnityEngine;
using UnityEngine.SceneManagement;

namespace NetMQExample
{
    /// <summary>A scene whose time passes when Python steps.</summary>
    [AddComponentMenu("NetMQ Example/11 Gym Manager")]
    public class GymManager : SteppedBehaviour
    {
        [SerializeField, Tooltip("The environment")] private string endpoint = "tcp://127.0.0.1:5561";
        [SerializeField, Tooltip("The env_name in Python")] private string envName = "Coins";
        [SerializeField, Tooltip("Seconds of a tick")] private double dt = 0.1;

        // Its scene is left: that of the next one takes its connection, or it ends.
        private static GymManager leaving;

        private bool quits;

        /// <summary>The one of this scene, if there is one.</summary>
        public static GymManager Current { get; private set; }

        /// <summary>Whether Python steps the agents, or will: else they play by the clock.</summary>
        internal static bool Steps => Current != null && Current.isActiveAndEnabled;

        /// <summary>What the environment itself says and hears, as GymEnv does. New after each enable, but not after a
        /// change of scenes.</summary>
        public SceneSimulator Simulator { get; private set; }

        /// <inheritdoc/>
        protected override string Endpoint => endpoint;

        /// <inheritdoc/>
        protected override SimulatorBase MakeSimulator() => Simulator;

        /// <inheritdoc/>
        protected override void Begin()
        {
            var before = leaving;
            leaving = null;
            Current = this;
            if (!(before is null) && before.envName == envName && before.endpoint == endpoint && GoOnWith(before))
            {
                Simulator = before.Simulator;
                return;
            }
            before?.Leave();
            Simulator = new SceneSimulator(
                envName, dt, Agent.All, SensorComponent.All, () => Physics.Simulate((float)dt))
            { Loads = Loads, Warn = Debug.LogWarning, Exists = agent => (Agent)agent != null };
            GymEnv.Simulator = Simulator;
            base.Begin();
        }

        /// <inheritdoc/>
        protected override void OnDisable()
        {
            if (quits || !(Simulator.Loading || Loads()))
            {
                Leave();
                return;
            }
            leaving = this;
            SceneManager.sceneLoaded += Loaded;
        }

        /// <inheritdoc/>
        protected override void Update()
        {
            AgentRoster.Settle(Agent.Refuse);
            base.Update();
        }

        /// <inheritdoc/>
        protected override void OnApplicationQuit()
        {
            quits = true;
            base.OnApplicationQuit();
        }

        private void Leave() => base.OnDisable();

        private void Loaded(Scene scene, LoadSceneMode mode)
        {
            SceneManager.sceneLoaded -= Loaded;
            if (!ReferenceEquals(leaving, this)) return;
            leaving = null;
            Debug.LogWarning(
                $"trouble: {scene.name} has no GymManager with the Env Name {envName}: Python has lost it");
            Leave();
        }

        // The one that is being loaded is the last one.
        private static bool Loads() => !SceneManager.GetSceneAt(SceneManager.sceneCount - 1).isLoaded;
    }
}
