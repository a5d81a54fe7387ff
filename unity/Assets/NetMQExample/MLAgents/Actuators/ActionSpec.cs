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

        /// <summary>How many choices each branch has.</summary>
        [Tooltip("The number of choices of each branch")] public int[] BranchSizes;

        /// <summary>With both.</summary>
        public ActionSpec(int numContinuousActions = 0, int[] discreteBranchSizes = null)
        {
            m_NumContinuousActions = numContinuousActions;
            BranchSizes = discreteBranchSizes ?? Array.Empty<int>();
        }

        /// <summary>How many numbers.</summary>
        public int NumContinuousActions { get => m_NumContinuousActions; set => m_NumContinuousActions = value; }

        /// <summary>How many branches.</summary>
        public int NumDiscreteActions => BranchSizes?.Length ?? 0;

        /// <summary>How many choices all branches have together.</summary>
        public int SumOfDiscreteBranchSizes => BranchSizes?.Sum() ?? 0;

        /// <summary>Numbers alone.</summary>
        public static ActionSpec MakeContinuous(int numActions) => new ActionSpec(numActions, null);

        /// <summary>Branches alone.</summary>
        public static ActionSpec MakeDiscrete(params int[] branchSizes) => new ActionSpec(0, branchSizes);

        /// <summary>The numbers and branches of all, one after the other.</summary>
        public static ActionSpec Combine(params ActionSpec[] specs) => new ActionSpec(
            specs.Sum(spec => spec.NumContinuousActions),
            specs.SelectMany(spec => spec.BranchSizes ?? Array.Empty<int>()).ToArray());
    }
}
