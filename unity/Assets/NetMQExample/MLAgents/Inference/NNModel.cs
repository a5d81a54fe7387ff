// ML-Agents' shape, models: the types that a script names. The kit runs no models.
using UnityEngine;

namespace NetMQExample.MLAgents.Inference
{
    /// <summary>A model of BehaviorParameters: any asset, which reads as one of those below without a cast.</summary>
    public sealed class AnyModel
    {
        private readonly Object asset;

        private AnyModel(Object asset) => this.asset = asset;

        public static implicit operator AnyModel(Object asset) => asset == null ? null : new AnyModel(asset);
        public static implicit operator Object(AnyModel model) => model?.asset;
        public static implicit operator NNModel(AnyModel model) => model?.asset as NNModel;
        public static implicit operator ModelAsset(AnyModel model) => model?.asset as ModelAsset;
    }

    /// <summary>A model as Barracuda named it, of ML-Agents 1 and 2. It is not run.</summary>
    public class NNModel : ScriptableObject { }

    /// <summary>A model as Sentis names it, of ML-Agents 3. It is not run.</summary>
    public class ModelAsset : ScriptableObject { }
}
