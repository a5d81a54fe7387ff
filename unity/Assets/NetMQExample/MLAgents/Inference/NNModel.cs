// ML-Agents' shape, models: the types that a script names. The kit runs no models.
using UnityEngine;

namespace NetMQExample.MLAgents.Inference
{
    /// <summary>A model as Barracuda named it, of ML-Agents 1 and 2. It is not run.</summary>
    public class NNModel : ScriptableObject { }

    /// <summary>A model as Sentis names it, of ML-Agents 3. It is not run.</summary>
    public class ModelAsset : ScriptableObject { }

    /// <summary>Where a model would run. Nothing here depends on it.</summary>
    public enum InferenceDevice
    {
        /// <summary>As the inference package likes.</summary>
        Default = 0,
        /// <summary>On the graphics card.</summary>
        GPU = 1,
        /// <summary>The name of 3.0 for it.</summary>
        ComputeShader = 1,
        /// <summary>On the processor, compiled.</summary>
        Burst = 2,
        /// <summary>On the processor.</summary>
        CPU = 3,
        /// <summary>The name of 3.0 for the same number.</summary>
        PixelShader = 3,
    }
}
