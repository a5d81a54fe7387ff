// Lesson 13, parameters: numbers by name for a scene, or how to draw them by chance. From Python to Unity.
//
//     var gravity = Academy.Instance.EnvironmentParameters.GetWithDefault("gravity", 9.81f);
//
// Bytes: string key, int32 type; type 0 is followed by a float32, type 1 by int32 seed, int32 kind of sampler and what
// that takes. The Python side is environment_parameters_channel.py.
using System;
using System.Collections.Generic;
using System.Linq;
using NetMQExample.MLAgents.SideChannels;

namespace NetMQExample.MLAgents
{
    /// <summary>The parameters that came, each a number or a sampler.</summary>
    public sealed class EnvironmentParameters : SideChannel
    {
        private readonly Dictionary<string, Func<float>> parameters = new Dictionary<string, Func<float>>();
        private readonly Dictionary<string, Action<float>> callbacks = new Dictionary<string, Action<float>>();

        public EnvironmentParameters() => ChannelId = new Guid("534c891e-810f-11ea-a9d0-822485860400");

        /// <summary>Of a sampler each call draws another number.</summary>
        public float GetWithDefault(string key, float defaultValue) =>
            parameters.TryGetValue(key, out var value) ? value() : defaultValue;

        /// <summary>One for each key, called when a number comes for it, and not for a sampler.</summary>
        public void RegisterCallback(string key, Action<float> action) => callbacks[key] = action;

        public IList<string> Keys() => parameters.Keys.ToList();

        protected override void OnMessageReceived(IncomingMessage msg)
        {
            var key = msg.ReadString("");
            var kind = msg.ReadInt32();
            if (kind == 1) parameters[key] = Sampler(msg);
            else if (kind == 0)
            {
                var value = msg.ReadFloat32();
                parameters[key] = () => value;
                if (callbacks.TryGetValue(key, out var action)) action(value);
            }
            else throw new UnityAgentsException(
                $"parameters are of type 0 or 1, not {kind}: are both sides of one release?");
        }

        private static Func<float> Sampler(IncomingMessage msg)
        {
            var seed = msg.ReadInt32();
            var kind = msg.ReadInt32();
            switch (kind)
            {
                case 0: return Samplers.Uniform(msg.ReadFloat32(), msg.ReadFloat32(), seed);
                case 1: return Samplers.Gaussian(msg.ReadFloat32(), msg.ReadFloat32(), seed);
                case 2: return Samplers.MultiRangeUniform(msg.ReadFloatList(new float[0]), seed);
                default:
                    throw new UnityAgentsException($"samplers are 0 to 2, not {kind}: are both sides of one release?");
            }
        }
    }
}
