// Lesson 11 in Unity: derive from this, mark the fields that an agent sees, and say what it does with an action.
//
// Use: put your component on a game object, and a GymManager anywhere in the scene.
//
//     public sealed class Runner : Agent
//     {
//         [Box] private Vector3 velocity;
//         [Discrete] private int lives = 3;
//         public override void OnReset() => transform.position = Vector3.zero;
//         public override void OnAction(object action) { … }
//     }
using System;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>It sees and acts. While it is enabled it takes part, so it may come late.</summary>
    [DisallowMultipleComponent]
    public abstract class Agent : MonoBehaviour, IAgent
    {
        [SerializeField, Tooltip("What Python calls it")] private string agentName = "agent";
        [SerializeField, Min(1), Tooltip("How many ticks one of its steps takes")] private int stepPeriod = 1;

        private AgentState state;

        /// <summary>All that take part now. For the main thread.</summary>
        public static List<IAgent> All => AgentRoster.All;

        /// <summary>Its name in Python. A script that makes agents names each one as soon as it is made.</summary>
        public string Name
        {
            get => agentName;
            set
            {
                var before = state;
                agentName = value;
                state = null;
                if (AgentRoster.Leave(this)) Join();
                if (before != null) state?.GoOnFrom(before, false);
            }
        }

        /// <summary>How many ticks one of its steps takes.</summary>
        public int StepPeriod
        {
            get => stepPeriod;
            set => State.Period = stepPeriod = value;
        }

        /// <inheritdoc/>
        public AgentState State => state ??= MakeState();

        /// <summary>The random numbers of this episode, which Python's seed decides.</summary>
        protected RandomGenerator RandomGenerator => State.RandomGenerator;

        /// <inheritdoc/>
        public abstract void OnReset();

        /// <inheritdoc/>
        public abstract void OnAction(object action);

        /// <inheritdoc/>
        public virtual void OnInfo(object info) { }

        /// <inheritdoc/>
        public virtual void OnTick(double dt) { }

        /// <summary>Reads the attributes of its class, once.</summary>
        protected virtual AgentState MakeState() => new AgentState(Name, this, stepPeriod);

        /// <summary>Adds to the reward that goes with the next answer.</summary>
        public void AddReward(double more) => State.AddReward(more);

        /// <summary>Replaces the reward that goes with the next answer.</summary>
        public void SetReward(double all) => State.SetReward(all);

        /// <summary>The episode is over for it: it has reached an end of the world.</summary>
        public void Terminate() => State.Terminate();

        /// <summary>The episode is over for it, for another reason, such as the time.</summary>
        public void Truncate() => State.Truncate();

        /// <summary>Tells Python something, with the next answer.</summary>
        public void SendInfo(object info) => State.SendInfo(info);

        /// <summary>Comes. An override calls base.OnEnable().</summary>
        protected virtual void OnEnable()
        {
            var first = state == null;
            Join();
            const BindingFlags Own =
                BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic | BindingFlags.DeclaredOnly;
            // Not in Start, which an agent may have itself.
            for (var type = GetType(); first && enabled && type != typeof(Agent); type = type.BaseType)
                if (type.GetMethod("FixedUpdate", Own) != null)
                    Debug.LogWarning($"trouble: {type.Name}.FixedUpdate runs by the clock: "
                        + "what belongs to a step is done in OnTick(double dt)");
        }

        /// <summary>Leaves. An override calls base.OnDisable().</summary>
        protected virtual void OnDisable() => AgentRoster.Leave(this);

        // All of the scene are enabled before the first one starts; one agent says it for all.
        private void Start()
        {
            if (!GymManager.Steps && ReferenceEquals(All.FirstOrDefault(), this))
                Debug.LogWarning("trouble: no GymManager is enabled in this scene: its agents play without Python");
        }

        // Without Python, by the clock.
        private void FixedUpdate()
        {
            if (GymManager.Steps) return;
            if (State.Over)
            {
                Debug.Log(FormattableString.Invariant($"by hand: {Name} has ended, return {State.Reward:F1}"));
                State.Begin(new RandomGenerator(Time.frameCount), State.Options);
                OnReset();
            }
            OnTick(Time.fixedDeltaTime);
        }

        internal static void Refuse(IAgent agent) =>
            ((Agent)agent).GiveUp($"two agents are named '{agent.State.Name}': each needs a name of its own");

        private void Join()
        {
            Observed.Engine = UnityValues.Numbers;
            try
            {
                AgentRoster.Join(this);
            }
            catch (ArgumentException e)
            {
                GiveUp(e.Message);
            }
        }

        // Python is told when it asks for this name.
        private void GiveUp(string why)
        {
            Debug.LogError($"gave up: {why}");
            enabled = false;
            AgentRoster.Refuse(this, agentName, why);
        }
    }
}
