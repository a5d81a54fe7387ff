// Lesson 09 in Unity: derive from this, and Python decides what your agent does, and when time passes for it.
//
// Use: put your component on a game object, and a GymManager anywhere in the scene.
//
//     public sealed class Ball : Agent
//     {
//         private double place, speed;
//
//         public override GymSpace Observation { get; } = GymSpace.Box(-12, 12, 2);
//         public override GymSpace Action { get; } = GymSpace.Discrete(3);
//
//         public override void OnReset() => (place, speed) = (Rng.Next() - 0.5, 0);
//         public override void OnAction(SpaceReader action) => speed += (action[0] - 1) * Dt;
//         public override void OnTick(double dt) => place += speed * dt;
//         public override void OnStepped() { AddReward(-Math.Abs(place)); if (Math.Abs(place) > 10) Terminate(); }
//         public override void Observe(SpaceWriter seen) => seen.Add(place, speed);
//     }
//
// One whose fields have attributes (Obs.cs) leaves out the spaces and Observe.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Reflection;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>It sees and acts. While it is enabled it takes part, so it may come late.</summary>
    [DisallowMultipleComponent]
    public abstract class Agent : MonoBehaviour, IAgent
    {
        [SerializeField, Tooltip("What Python calls it; several of one name get numbers")]
        private string agentName = "agent";
        [SerializeField, Min(1), Tooltip("How many ticks one of its steps takes")] private int stepPeriod = 1;

        private AgentState state;
        private PlainAgent plain;

        /// <summary>All that take part now. For the main thread.</summary>
        public static List<IAgent> All { get; } = new List<IAgent>();

        /// <summary>Its name in Python. A script that makes agents names each one as soon as it is made.</summary>
        public string Name
        {
            get => state?.Name ?? agentName;
            set
            {
                agentName = Require.Given("Name", value);
                state?.Call(value, true);
                // An agent that gave up because of its name has another one.
                if (state == null && isActiveAndEnabled) OnEnable();
            }
        }

        public int StepPeriod
        {
            get => stepPeriod;
            set
            {
                stepPeriod = value;
                if (state != null) state.Period = value;
            }
        }

        AgentState IAgent.AgentState => Own;

        public virtual GymSpace Observation => plain?.Observation;
        public virtual GymSpace Action => plain?.Action;

        /// <summary>How many numbers the option "state" has, in which an episode can begin.</summary>
        protected virtual int StateSize => 0;

        /// <summary>The random numbers of this episode, which Python's seed decides.</summary>
        protected RandomGenerator Rng => Own.Rng;

        protected IReadOnlyDictionary<string, object> Options => Own.Options;

        /// <summary>The option "state": <see cref="StateSize"/> numbers, or none.</summary>
        protected double[] FirstState => Own.FirstState;

        /// <summary>Named infos of this step, for Python.</summary>
        public IDictionary<string, object> Info => Own.Info;

        protected double Dt => Own.Dt;

        // Made also for the only agent: what is wrong with its members is said when it comes.
        private AgentState Own
        {
            get
            {
                if (state != null) return state;
                Observed.Engine = UnityValues.Numbers;
                plain = MakePlain(agentName);
                state = plain?.AgentState ?? new AgentState(agentName, this) { StateSize = StateSize };
                state.Period = stepPeriod;
                return state;
            }
        }

        public virtual void OnReset() => plain?.OnReset();

        public virtual void OnAction(SpaceReader action)
        {
            if (plain == null) OnAction(action.Value);
            else plain.OnAction(action);
        }

        public virtual void OnAction(object action) => plain?.OnAction(action);
        public virtual void OnTick(double dt) => plain?.OnTick(dt);
        public virtual void OnStepped() => plain?.OnStepped();
        public virtual void Observe(SpaceWriter seen) => plain?.Observe(seen);
        public virtual void OnInfo(object info) => plain?.OnInfo(info);
        public virtual MessageArray Render() => plain?.Render();

        /// <summary>The action of a person who plays by hand, from Input: numbers (double[]), or any value of its
        /// space; null: it does nothing, which is zeros.</summary>
        public virtual object Heuristic() => null;

        /// <summary>Makes an agent without Unity, which does all that this class does not override; null: it does
        /// nothing, and the attributes are those of this class.</summary>
        protected virtual PlainAgent MakePlain(string name) => null;

        /// <summary>Adds to the reward that goes with the next answer.</summary>
        public void AddReward(double more) => Own.AddReward(more);

        /// <summary>Replaces the reward that goes with the next answer.</summary>
        public void SetReward(double all) => Own.SetReward(all);

        /// <summary>The episode is over for it: it has reached an end of the world.</summary>
        public void Terminate() => Own.Terminate();

        /// <summary>The episode is over for it, for another reason, such as the time.</summary>
        public void Truncate() => Own.Truncate();

        /// <summary>Tells Python something, with the next answer.</summary>
        public void SendInfo(object info) => Own.SendInfo(info);

        /// <summary>Comes. An override calls base.OnEnable().</summary>
        protected virtual void OnEnable()
        {
            var first = state == null;
            try { _ = Own; }
            catch (ArgumentException e)
            {
                GiveUp(e.Message);
                return;
            }
            GaveUp = false;
            if (!All.Contains(this)) All.Add(this);
            if (!first) return;
            WarnOfClock();
            StartCoroutine(LookForManager());
        }

        /// <summary>Leaves. An override calls base.OnDisable().</summary>
        protected virtual void OnDisable() => All.Remove(this);

        // Of no use to Python: what is wrong with it was said.
        internal bool GaveUp { get; private set; }

        // Of the one that gave up last; for Python, if there is nobody else.
        internal static string Mistake { get; private set; } = "none is in the scene";

        internal void GiveUp(string why)
        {
            GaveUp = true;
            Mistake = why;
            Debug.LogError($"gave up: {why}");
            enabled = false;
        }

        // Not in Start, which an agent may have itself.
        private void WarnOfClock()
        {
            const BindingFlags Declared =
                BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic | BindingFlags.DeclaredOnly;
            for (var type = GetType(); type != typeof(Agent); type = type.BaseType)
                if (type.GetMethod("FixedUpdate", Declared) != null)
                    Debug.LogWarning($"trouble: {type.Name}.FixedUpdate runs by the clock: "
                        + "what belongs to a step is done in OnTick(double dt)");
        }

        // All of the scene are enabled by then; one agent says it for all.
        private IEnumerator LookForManager()
        {
            yield return null;
            if (GymManager.Current == null && All.Count > 0 && ReferenceEquals(All[0], this))
                Debug.LogWarning("trouble: no GymManager is enabled in this scene: its agents do nothing");
        }
    }
}
