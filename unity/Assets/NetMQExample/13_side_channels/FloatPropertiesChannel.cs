// Lesson 13, properties: numbers by name that both sides have, and each tells the other what it sets.
//
// Bytes: string key, float32 value. The Python side is float_properties_channel.py.
using System;
using System.Collections.Generic;
using System.Linq;

namespace NetMQExample.MLAgents.SideChannels
{
    /// <summary>Numbers by name.</summary>
    public class FloatPropertiesChannel : SideChannel
    {
        // Limits for the properties that the other side sends.
        private const int MostProperties = 10000, LongestName = 1000;

        private readonly Dictionary<string, float> properties = new Dictionary<string, float>();
        private readonly Dictionary<string, Action<float>> callbacks = new Dictionary<string, Action<float>>();

        /// <summary>With ML-Agents' id, or another one.</summary>
        public FloatPropertiesChannel(Guid channelId = default) =>
            ChannelId = channelId == default ? new Guid("60ccf7d0-4f7e-11ea-b238-784f4387d1f7") : channelId;

        /// <summary>Sets it here and there.</summary>
        public void Set(string key, float value)
        {
            using var msg = new OutgoingMessage();
            msg.WriteString(key);
            msg.WriteFloat32(value);
            QueueMessageToSend(msg);
            Keep(key, value);
        }

        /// <summary>The newest value, from either side.</summary>
        public float GetWithDefault(string key, float defaultValue) =>
            properties.TryGetValue(key, out var value) ? value : defaultValue;

        /// <summary>One for each key, called whenever it is set.</summary>
        public void RegisterCallback(string key, Action<float> action) => callbacks[key] = action;

        public IList<string> Keys() => properties.Keys.ToList();

        protected override void OnMessageReceived(IncomingMessage msg)
        {
            var key = msg.ReadString("");
            if (key.Length > LongestName || (properties.Count >= MostProperties && !properties.ContainsKey(key)))
                throw new UnityAgentsException(
                    $"at most {MostProperties} properties, with names of at most {LongestName} characters");
            Keep(key, msg.ReadFloat32());
        }

        private void Keep(string key, float value)
        {
            properties[key] = value;
            if (callbacks.TryGetValue(key, out var action)) action(value);
        }
    }
}
