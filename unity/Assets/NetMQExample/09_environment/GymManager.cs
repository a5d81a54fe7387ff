// Lesson 09 in Unity: it brings all agents of the scene to Python.
//
// Use: start python/09_environment/server.py, open this lesson's scene, press Play. For your own scene: add this
// component to any GameObject, and agents (Agent.cs) and sensors wherever they belong.
// Nothing moves while Python thinks: for each step OnTick is called, and physics is simulated for as long. A script
// moves its FixedUpdate to OnTick. The world, which belongs to no agent, has its place here: derive from it.
// A scene may be loaded anew, also by an agent's OnReset: the new scene's GymManager goes on with the connection.
using System;
using System.Collections.Generic;
using System.Linq;
using UnityEngine;
using UnityEngine.SceneManagement;

namespace NetMQExample
{
    /// <summary>A scene whose time passes when Python steps, or by the clock when a person plays it by hand.</summary>
    [AddComponentMenu("NetMQ Example/09 Gym Manager")]
    public class GymManager : SteppedBehaviour, IWorld
    {
        [SerializeField, Tooltip("The environment")] private string endpoint = "tcp://127.0.0.1:5559";
        [SerializeField, Tooltip("The env_name in Python")] private string envName = "CartPole";
        [SerializeField, Tooltip("Seconds of a tick")] private double dt = 0.02;
        [SerializeField, Tooltip("Play with Heuristic, without Python; from the next Play on")] private bool byHand;
        [SerializeField, Tooltip("How many agents of a name there may be, where some come later")]
        private NameCount[] atMost = new NameCount[0];

        private ByHand played;

        public static GymManager Current { get; private set; }

        /// <summary>The environment's own side. New after each enable, but not after a change of scenes.</summary>
        public SceneSimulator Simulator { get; private set; }

        /// <summary>The env_name in Python. Set it before it is enabled, such as in Awake.</summary>
        public string EnvName { get => envName; set => envName = value; }

        /// <summary>Seconds of a tick. Set it before it is enabled, such as in Awake.</summary>
        public double Dt { get => dt; set => dt = value; }

        protected override string Endpoint => endpoint;
        protected override bool Connects => played == null;

        protected override SimulatorBase MakeSimulator() => Simulator;
        public virtual void OnReset(RandomGenerator random, IReadOnlyDictionary<string, object> options) { }
        public virtual void OnTick(double dt) { }
        public virtual void OnStepped() { }
        public virtual MessageArray Render() => null;

        /// <inheritdoc cref="SceneSimulator.SendInfo"/>
        public void SendInfo(object info) => Simulator.SendInfo(info);

        /// <summary>The action of a person who plays an agent by hand.</summary>
        protected virtual object Heuristic(IAgent agent) => (agent as Agent)?.Heuristic();

        protected override void Begin()
        {
            if (Current != null && Current != this)
                throw new ArgumentException($"{Current.name} and {name} have a GymManager each: remove one");
            Current = this;
            var before = SceneChange.Take(endpoint, EnvName);
            if (!(before is null) && GoOnWith(before))
            {
                Simulator = before.Simulator;
                Simulator.ForgetListeners();
                Simulator.Moves.World = this;
                Simulator.Roster.Loaded = true;
                GymEnv.Simulator = Simulator;
                return;
            }
            Simulator = new SceneSimulator(EnvName, Dt, Agent.All, this, SensorComponent.All)
            {
                Loads = SceneChange.Loads,
                Warn = Debug.LogWarning,
                Refuse = (agent, why) => (agent as Agent)?.GiveUp(why),
                WhyNobody = () => Agent.Mistake,
            };
            Simulator.Roster.Everyone = Everyone;
            Simulator.Roster.Exists = agent => !(agent is Agent one) || one != null;
            Simulator.Moves.Physics = () => Physics.Simulate((float)Dt);
            foreach (var one in atMost) Simulator.AtMost[one.name] = one.count;
            GymEnv.Simulator = Simulator;
            played = byHand ? new ByHand(Simulator, Dt, Heuristic) : null;
            Enter();
        }

        /// <summary>A connection begins; a scene that is loaded while Python steps goes on with the last.</summary>
        protected virtual void Enter() => base.Begin();

        protected virtual void Leave() => base.OnDisable();

        protected override void OnDisable()
        {
            // A second one has begun nothing.
            if (Current != this) return;
            Current = null;
            var changes = !Ending && (Simulator.Loading || SceneChange.Loads());
            if (changes) SceneChange.Leave(this, endpoint, EnvName, Leave);
            else Leave();
        }

        /// <summary>Time by the clock, for who plays by hand or in real time.</summary>
        protected virtual void FixedUpdate()
        {
            if (played != null) played.Tick(Time.fixedDeltaTime);
            // If Python wants real time the scene moves on while it thinks; else this does nothing.
            else Simulator?.CatchUp();
        }

        // In the order of the hierarchy. Objects that Unity keeps over all scenes come last.
        private IReadOnlyList<IAgent> Everyone()
        {
            var found = new List<IAgent>();
            for (var i = 0; i < SceneManager.sceneCount; i++)
                if (SceneManager.GetSceneAt(i).isLoaded)
                    foreach (var root in SceneManager.GetSceneAt(i).GetRootGameObjects())
                        found.AddRange(root.GetComponentsInChildren<Agent>(true).Where(one => !one.GaveUp));
            found.AddRange(Agent.All.Where(agent => !found.Contains(agent)).ToList());
            return found;
        }
    }

    /// <summary>How many agents of a name there may be.</summary>
    [Serializable]
    public struct NameCount
    {
        public string name;
        public int count;
    }
}
