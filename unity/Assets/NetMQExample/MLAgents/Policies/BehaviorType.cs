// ML-Agents' shape, who decides for an agent, and which of its members are observed.
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
