// ML-Agents' shape, the decision requester: its agent asks for a decision every few steps of the academy.
//
// Use: put it on the agent's GameObject. Scenes of ML-Agents have it already.
using UnityEngine;
using UnityEngine.Serialization;

namespace NetMQExample.MLAgents
{
    /// <summary>Asks for the agent on the same GameObject.</summary>
    [AddComponentMenu("NetMQ Example/ML-Agents/Decision Requester")]
    [RequireComponent(typeof(Agent)), DefaultExecutionOrder(-10)]
    public class DecisionRequester : MonoBehaviour
    {
        [Range(1, 20), Tooltip("How many steps from one decision to the next")] public int DecisionPeriod = 5;
        [Range(0, 19), Tooltip("In which of these steps it decides, from 0 on")] public int DecisionStep;

        [FormerlySerializedAs("RepeatAction"), Tooltip("Whether it acts in the steps between as well")]
        public bool TakeActionsBetweenDecisions = true;

        /// <summary>The step for which it may ask.</summary>
        public struct DecisionRequestContext
        {
            public int AcademyStepCount;
        }

        public Agent Agent { get; private set; }

        protected virtual bool ShouldRequestDecision(DecisionRequestContext context) =>
            DecisionPeriod > 0 && context.AcademyStepCount % DecisionPeriod == DecisionStep;

        protected virtual bool ShouldRequestAction(DecisionRequestContext context) => TakeActionsBetweenDecisions;

        private void Awake()
        {
            if (DecisionStep >= DecisionPeriod)
                Debug.LogError($"{name}: it never decides: Decision Step is below Decision Period ({DecisionPeriod})");
            Agent = GetComponent<Agent>();
            Academy.Instance.AgentPreStep += Ask;
        }

        private void OnDestroy()
        {
            if (Academy.IsInitialized) Academy.Instance.AgentPreStep -= Ask;
        }

        private void Ask(int academyStepCount)
        {
            var context = new DecisionRequestContext { AcademyStepCount = academyStepCount };
            if (ShouldRequestDecision(context)) Agent.RequestDecision();
            if (ShouldRequestAction(context)) Agent.RequestAction();
        }
    }
}
