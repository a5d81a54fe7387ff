// Lesson 11 in Unity: what an agent sees is said where it is declared. This brings all agents of the scene to Python.
//
// Use: start python/11_observations/server.py, open this lesson's scene, press Play. For your own scene: add this
// component to any GameObject, and agents (Agent.cs) and sensors wherever they belong.
// Nothing moves while Python thinks: for each step OnTick is called, and physics is simulated for as long. A
// script moves its FixedUpdate to OnTick. While it is disabled, the agents play without Python.
// A scene may be loaded anew, also by an agent's OnReset: the new scene's GymManager goes on with the connection.
using UnityEngine;

namespace NetMQExample
{
    /// <summary>A scene whose time passes when Python steps.</summary>
    [AddComponentMenu("NetMQ Example/11 Gym Manager")]
    public class GymManager : SteppedBehaviour
    {
        [SerializeField, Tooltip("The environment")] private string endpoint = "tcp://127.0.0.1:5561";
        [SerializeField, Tooltip("The env_name in Python")] private string envName = "Coins";
        [SerializeField, Tooltip("Seconds of a tick")] private double dt = 0.1;

        /// <summary>The one of this scene, if there is one.</summary>
        public static GymManager Current { get; private set; }

        /// <summary>Whether Python steps the agents, or will: else they play by the clock.</summary>
        internal static bool Steps => Current != null && Current.isActiveAndEnabled;

        /// <summary>The environment's own side, as of GymEnv. New after each enable, but not after a
        /// change of scenes.</summary>
        public SceneSimulator Simulator { get; private set; }

        /// <inheritdoc/>
        protected override string Endpoint => endpoint;

        /// <inheritdoc/>
        protected override SimulatorBase MakeSimulator() => Simulator;

        /// <inheritdoc/>
        protected override void Begin()
        {
            Current = this;
            var before = SceneChange.Take(endpoint, envName);
            if (!(before is null) && GoOnWith(before))
            {
                Simulator = before.Simulator;
                Simulator.ForgetListeners();
                GymEnv.Simulator = Simulator;
                return;
            }
            Simulator = new SceneSimulator(
                envName, dt, Agent.All, SensorComponent.All, () => Physics.Simulate((float)dt))
            { Loads = SceneChange.Loads, Warn = Debug.LogWarning, Exists = agent => (Agent)agent != null };
            GymEnv.Simulator = Simulator;
            Enter();
        }

        /// <summary>A connection begins. A scene that is loaded while Python steps goes on with the one before.
        /// </summary>
        protected virtual void Enter() => base.Begin();

        /// <summary>The connection ends.</summary>
        protected virtual void Leave() => base.OnDisable();

        /// <inheritdoc/>
        protected override void OnDisable()
        {
            var changes = !Ending && (Simulator.Loading || SceneChange.Loads());
            if (changes) SceneChange.Leave(this, endpoint, envName, Leave);
            else Leave();
        }

        /// <inheritdoc/>
        protected override void Update()
        {
            AgentRoster.Settle(Agent.Refuse);
            base.Update();
        }
    }
}
