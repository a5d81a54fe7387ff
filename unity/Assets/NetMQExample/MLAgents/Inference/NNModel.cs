// ML-Agents' shape, models: the types that a script names. The kit runs no models.
using UnityEngine;

namespace NetMQExample.MLAgents.Inference
{
    /// <summary>A model as Barracuda named it, of ML-Agents 1 and 2. It is not run.</summary>
    public class NNModel : ScriptableObject { }

    /// <summary>A model as Sentis names it, of ML-Agents 3. It is not run.</summary>
    public class ModelAsset : ScriptableObject { }
}
