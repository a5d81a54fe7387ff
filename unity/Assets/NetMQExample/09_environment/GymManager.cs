// Lesson 09 in Unity: it brings all agents of the scene to Python.
using System;
using System.Collections.Generic;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>A scene whose time passes when Python steps.</summary>
    [AddComponentMenu("NetMQ Example/09 Gym Manager")]
    public class GymManager : SteppedBehaviour, IWorld
    {
        [SerializeField, Tooltip("The environment")] private string endpoint = "tcp://127.0.0.1:5559";
        [SerializeField, Tooltip("The env_name in Python")] private string envName = "CartPole";
        [SerializeField, Tooltip("Seconds of a tick")] private double dt = 0.02;
        [SerializeField, Tooltip("Play with Heuristic, without Python; from the next Play on")] private bool byHand;
        [SerializeField, Tooltip("How many agents of a name there may be, where some come later")]
        private NameCount[] atMost = new NameCount[0];

        /// <summary>The one of this scene, if there is one.</summary>
        public static GymManager Current { get; private set; }

        /// <summary>The env_name in Python. Set it before it is enabled.</summary>
        public string EnvName { get => envName; set => envName = value; }

        /// <summary>Seconds of a tick. Set it before it is enabled.</summary>
        public double Dt { get => dt; set => dt = value; }

        /// <summary>The environment's own side, as of GymEnv. New after each enable, but not after a change of scenes.
        /// </summary>
        public SceneSimulator Simulator { get; private set; }

        /// <inheritdoc/>
        protected override string Endpoint => endpoint;

        /// <inheritdoc/>
        protected override SimulatorBase MakeSimulator() => Simulator;

        /// <summary>Tells Python something of the environment, with the next answer.</summary>
        public void SendInfo(object info) => Simulator.SendInfo(info);

        /// <summary>Hears what Python sends to the environment itself.</summary>
        public event Action<object> OnInfo;

        /// <inheritdoc/>
        public virtual void OnReset(RandomGenerator random, IReadOnlyDictionary<string, object> options) { }

        /// <inheritdoc/>
        public virtual void OnTick(double dt) { }

        /// <inheritdoc/>
        public virtual void OnStepped() { }

        /// <inheritdoc/>
        public virtual MessageArray Render() => null;

        /// <summary>A connection begins. A scene that is loaded while Python steps goes on with the one before.
        /// </summary>
        protected virtual void Enter() => base.Begin();

        /// <summary>The connection ends.</summary>
        protected virtual void Leave() => base.OnDisable();
    }

    /// <summary>How many agents of a name there may be.</summary>
    [Serializable]
    public struct NameCount
    {
        /// <summary>Their Agent Name.</summary>
        public string name;

        /// <summary>At most so many at once.</summary>
        public int count;
    }
}
