// ML-Agents' shape, brain parameters: the sizes of what an agent sees and does. Scenes of ML-Agents 1.0 to 1.7, which
// have VectorActionSize and VectorActionSpaceType, are read as ML-Agents 2 reads them.
using System;
using NetMQExample.MLAgents.Actuators;
using UnityEngine;
using UnityEngine.Serialization;

namespace NetMQExample.MLAgents.Policies
{
    /// <summary>Sizes. The fields have ML-Agents' names in scenes.</summary>
    [Serializable]
    public class BrainParameters : ISerializationCallbackReceiver
    {
        /// <summary>How many numbers CollectObservations adds; 0: it is called with null.</summary>
        [FormerlySerializedAs("vectorObservationSize"), Min(0)] public int VectorObservationSize = 1;

        /// <summary>How many observations of this and earlier decisions go together, the oldest first.</summary>
        [FormerlySerializedAs("numStackedVectorObservations"), Range(1, 50)]
        public int NumStackedVectorObservations = 1;

        [FormerlySerializedAs("vectorActionDescriptions")] public string[] VectorActionDescriptions;
        [SerializeField] internal ActionSpec m_ActionSpec = new ActionSpec(0, null);

        // As before ML-Agents 1.8: one kind of actions alone, 0 discrete and 1 continuous.
        [SerializeField, HideInInspector, FormerlySerializedAs("vectorActionSize")]
        internal int[] VectorActionSize = { 1 };
        [SerializeField, HideInInspector, FormerlySerializedAs("vectorActionSpaceType")]
        internal int VectorActionSpaceType;
        [SerializeField, HideInInspector] internal bool hasUpgradedBrainParametersWithActionSpec;

        public ActionSpec ActionSpec
        {
            get => m_ActionSpec;
            set
            {
                m_ActionSpec = value;
                hasUpgradedBrainParametersWithActionSpec = true;
            }
        }

        /// <summary>A copy, which shares nothing with this one.</summary>
        public BrainParameters Clone() => new BrainParameters
        {
            VectorObservationSize = VectorObservationSize,
            NumStackedVectorObservations = NumStackedVectorObservations,
            VectorActionDescriptions = (string[])VectorActionDescriptions?.Clone(),
            ActionSpec = new ActionSpec(m_ActionSpec.NumContinuousActions, (int[])m_ActionSpec.BranchSizes?.Clone()),
        };

        public void OnBeforeSerialize() => OnAfterDeserialize();

        public void OnAfterDeserialize()
        {
            var old = !hasUpgradedBrainParametersWithActionSpec && VectorActionSize?.Length > 0
                && m_ActionSpec.NumContinuousActions == 0 && m_ActionSpec.NumDiscreteActions == 0;
            if (old && VectorActionSpaceType == 1) m_ActionSpec = ActionSpec.MakeContinuous(VectorActionSize[0]);
            else if (old) m_ActionSpec = ActionSpec.MakeDiscrete((int[])VectorActionSize.Clone());
            hasUpgradedBrainParametersWithActionSpec = true;
        }
    }

    /// <summary>The one who decides for an agent.</summary>
    [Serializable]
    public enum BehaviorType
    {
        /// <summary>Python, or the agent's Heuristic where there is no Python.</summary>
        Default,
        /// <summary>The agent's Heuristic: Python never sees it.</summary>
        HeuristicOnly,
        /// <summary>A model, which the kit does not run.</summary>
        InferenceOnly,
    }

    /// <summary>Where a model would run. Nothing here depends on it.</summary>
    public enum InferenceDevice
    {
        Default = 0,
        GPU = 1,
        /// <summary>The name of 3.0 for it.</summary>
        ComputeShader = 1,
        Burst = 2,
        CPU = 3,
        /// <summary>The name of 3.0 for the same number.</summary>
        PixelShader = 3,
    }

    /// <summary>Which members with [Observable] an agent sees.</summary>
    public enum ObservableAttributeOptions
    {
        /// <summary>None: looking for them takes time.</summary>
        Ignore,
        /// <summary>Those of its own class.</summary>
        ExcludeInherited,
        /// <summary>Those of its base classes as well.</summary>
        ExamineAll,
    }
}
