// Lesson 11 in Unity: what an agent sees is said where it is declared. This brings all agents of the scene to Python.
//
// Use: start python/11_observations/server.py, open this lesson's scene, press Play. For your own scene: add this
// component to any GameObject, and agents (Agent.cs) and sensors wherever they belong.
// Nothing moves while Python thinks: for each step OnTick is called, and physics is simulated for as long. What a
// script does in FixedUpdate, it does in OnTick from now on.
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

        /// <summary>What the environment itself says and hears: SendInfo, OnInfo. New after each enable.</summary>
        public SceneSimulator Simulator { get; private set; }

        /// <inheritdoc/>
        protected override string Endpoint => endpoint;

        /// <inheritdoc/>
        protected override SimulatorBase MakeSimulator() => Simulator;

        /// <inheritdoc/>
        protected override void Begin()
        {
            Current = this;
            Simulator = new SceneSimulator(
                envName, dt, Agent.All, SensorComponent.All, () => Physics.Simulate((float)dt));
            base.Begin();
        }
    }
}
