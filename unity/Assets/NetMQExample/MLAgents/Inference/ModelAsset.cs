// ML-Agents' shape, a model as Sentis names it: the type that a script of ML-Agents 3 names.
using UnityEngine;

namespace NetMQExample.MLAgents.Inference
{
    /// <summary>A model. It is not run.</summary>
    public class ModelAsset : ScriptableObject { }
}
