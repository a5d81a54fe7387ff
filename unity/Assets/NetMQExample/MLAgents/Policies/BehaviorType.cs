// ML-Agents' shape, the choices in Behavior Parameters.
using System;

namespace NetMQExample.MLAgents.Policies
{
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
