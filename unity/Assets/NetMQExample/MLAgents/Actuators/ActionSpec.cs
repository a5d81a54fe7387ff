// ML-Agents' shape, a specification: how many continuous actions an agent has, and how many choices in each branch.
using System;
using System.Linq;
using UnityEngine;

namespace NetMQExample.MLAgents.Actuators
{
    /// <summary>Which actions there are. Its fields have ML-Agents' names in scenes.</summary>
    [Serializable]
    public struct ActionSpec
    {
        [SerializeField, Tooltip("Numbers without limits"), Min(0)] private int m_NumContinuousActions;

        [Tooltip("The number of choices of each branch")] public int[] BranchSizes;

        public ActionSpec(int numContinuousActions = 0, int[] discreteBranchSizes = null)
        {
            m_NumContinuousActions = numContinuousActions;
            BranchSizes = discreteBranchSizes ?? Array.Empty<int>();
        }

        public int NumContinuousActions { get => m_NumContinuousActions; set => m_NumContinuousActions = value; }
        public int NumDiscreteActions => BranchSizes?.Length ?? 0;
        public int SumOfDiscreteBranchSizes => BranchSizes?.Sum() ?? 0;

        public static ActionSpec MakeContinuous(int numActions) => new ActionSpec(numActions, null);
        public static ActionSpec MakeDiscrete(params int[] branchSizes) => new ActionSpec(0, branchSizes);

        public static ActionSpec Combine(params ActionSpec[] specs) => new ActionSpec(
            specs.Sum(spec => spec.NumContinuousActions),
            specs.SelectMany(spec => spec.BranchSizes ?? Array.Empty<int>()).ToArray());
    }
}
