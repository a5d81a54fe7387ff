// ML-Agents' shape, the agent: derive from this, and the script is the one that you have for ML-Agents.
//
//     using NetMQExample.MLAgents;              in place of using Unity.MLAgents;
//     using NetMQExample.MLAgents.Actuators;
//     using NetMQExample.MLAgents.Sensors;
//
//     public sealed class Ball : Agent
//     {
//         public override void OnEpisodeBegin() => transform.localPosition = Vector3.zero;
//         public override void CollectObservations(VectorSensor sensor) =>
//             sensor.AddObservation(transform.localPosition);
//         public override void OnActionReceived(ActionBuffers actions)
//         {
//             transform.Translate(actions.ContinuousActions[0], 0, 0);
//             AddReward(-0.01f);
//         }
//     }
//
// Use: put it on a GameObject with Behavior Parameters and a Decision Requester. Python drives it by
// UnityEnvironment, or by mlagents_learn. No name of a member is one of Unity's types, such as Random or Time.
using System;
using System.Collections.ObjectModel;
using NetMQExample.MLAgents.Actuators;
using NetMQExample.MLAgents.Policies;
using NetMQExample.MLAgents.Sensors;
using UnityEngine;
using UnityEngine.Serialization;

namespace NetMQExample.MLAgents
{
    /// <summary>It sees and acts while it is enabled. Its time is the scene's own: FixedUpdate.</summary>
    [RequireComponent(typeof(BehaviorParameters)), DefaultExecutionOrder(-50)]
    public class Agent : MonoBehaviour, IActionReceiver, IHeuristicProvider
    {
        /// <summary>After so many steps its episode is interrupted; 0: never.</summary>
        [FormerlySerializedAs("maxStep"), Min(0), Tooltip("Steps of an episode; 0: it has no end by time")]
        public int MaxStep;

        private AgentLife life;

        public int StepCount => Life.StepCount;
        public int CompletedEpisodes => Life.CompletedEpisodes;
        internal AgentLife Life => life ??= new AgentLife(this);

        /// <summary>Prepares it, once each time it is enabled, before others' Start.</summary>
        public virtual void Initialize() { }

        /// <summary>Begins an episode. The first one begins in the first step, after every Start.</summary>
        public virtual void OnEpisodeBegin() { }

        /// <summary>Adds what it sees; the sensor is null if Behavior Parameters has no vector observation.</summary>
        public virtual void CollectObservations(VectorSensor sensor) { }

        public virtual void WriteDiscreteActionMask(IDiscreteActionMask actionMask) { }

        /// <summary>Acts. Between two decisions it gets the same actions again; after an end zeros.</summary>
        public virtual void OnActionReceived(ActionBuffers actions) => Life.Old.Receive(actions);

        /// <summary>Decides where Python does not.</summary>
        public virtual void Heuristic(in ActionBuffers actionsOut) => Life.Old.Decide(actionsOut);

        /// <summary>Acts, as in ML-Agents of 2020, where the actions are of one kind.</summary>
        [Obsolete("write OnActionReceived(ActionBuffers actions)")]
        public virtual void OnActionReceived(float[] vectorAction) { }

        /// <summary>Decides, as in ML-Agents of 2020, where the actions are of one kind.</summary>
        [Obsolete("write Heuristic(in ActionBuffers actionsOut)")]
        public virtual void Heuristic(float[] actionsOut) => Life.Old.HasNone();

        /// <summary>Adds to the reward that goes with its next row.</summary>
        public void AddReward(float increment) =>
            Life.Earn(UnityAgentsException.Finite(increment, nameof(AddReward)), false);

        /// <summary>Replaces the reward that goes with its next row.</summary>
        public void SetReward(float reward) => Life.Earn(UnityAgentsException.Finite(reward, nameof(SetReward)), true);

        public float GetCumulativeReward() => Life.CumulativeReward;

        /// <summary>The episode is over; the next one begins before this returns.</summary>
        /// <exception cref="UnityAgentsException">It was called in OnEpisodeBegin or CollectObservations.</exception>
        public void EndEpisode() => Life.EndEpisode(nameof(EndEpisode), false);

        /// <summary>The same for another reason than an end of the task, such as the time.</summary>
        /// <exception cref="UnityAgentsException">It was called in OnEpisodeBegin or CollectObservations.</exception>
        public void EpisodeInterrupted() => Life.EndEpisode(nameof(EpisodeInterrupted), true);

        /// <summary>Asks for a decision in the next step, and acts by it.</summary>
        public void RequestDecision() => Life.Request(true);

        /// <summary>Acts once more in the next step, by the decision before.</summary>
        public void RequestAction() => Life.Request(false);

        /// <summary>The numbers that CollectObservations has added last.</summary>
        public ReadOnlyCollection<float> GetObservations() => Life.Vector.GetObservations();

        /// <summary>The same with the observations before.</summary>
        public ReadOnlyCollection<float> GetStackedObservations() => Life.Stacked.GetStackedObservations();

        public ActionBuffers GetStoredActionBuffers() => Life.Stored;

        /// <summary>Changes its behavior, by which its episode is over; a model is kept and not run.</summary>
        public void SetModel(
            string behaviorName, UnityEngine.Object model, InferenceDevice inferenceDevice = InferenceDevice.Default)
        {
            var settings = Life.Parameters;
            var same = behaviorName == settings.BehaviorName && model == settings.Model
                && inferenceDevice == settings.InferenceDevice;
            if (same) return;
            Life.Finish(false, true);
            settings.Model = model;
            settings.InferenceDevice = inferenceDevice;
            settings.BehaviorName = behaviorName;
        }

        /// <summary>Makes it ready, unless it is: OnEnable does that.</summary>
        public void LazyInitialize() => Life.Begin();

        /// <summary>Stretches an action from -1 to 1 over another range.</summary>
        protected static float ScaleAction(float rawAction, float min, float max) =>
            (min + max) / 2 + rawAction * (max - min) / 2;

        /// <summary>Does nothing; an Awake of yours may hide it.</summary>
        protected virtual void Awake() { }

        /// <summary>Comes. An override calls base.OnEnable().</summary>
        protected virtual void OnEnable() => LazyInitialize();

        /// <summary>Leaves. An override calls base.OnDisable().</summary>
        protected virtual void OnDisable() => Life.End();
    }
}
