// Lesson 04 with your own classes: client.Ask<State, Order>(state, order => Debug.Log(order.say), Debug.LogWarning);
//
// State and Order are classes with public fields, and JSON on the wire. In Python: @json_answer of replies.py.
// new() has a build keep the constructor of Order, which only JSON calls.
// It needs Newtonsoft.Json, in Unity the package com.unity.nuget.newtonsoft-json; without it delete this file.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Reflection;
using System.Threading;
using System.Threading.Tasks;
using Newtonsoft.Json;
using Newtonsoft.Json.Converters;
using Newtonsoft.Json.Linq;
using Newtonsoft.Json.Serialization;

namespace NetMQExample
{
    /// <summary>Requests and replies that are objects instead of texts.</summary>
    public static class BackgroundClientJson
    {
        // A misspelt key is an error, a missing one leaves its field as it is. An enum is sent as its name, so that
        // another order of its members changes nothing. No reply may name the class to make.
        private static readonly JsonSerializerSettings Rules = new JsonSerializerSettings
        {
            ContractResolver = new UnityFields(),
            Converters = { new StringEnumConverter(), new FiniteNumbers() },
            MissingMemberHandling = MissingMemberHandling.Error,
            TypeNameHandling = TypeNameHandling.None,
        };

        /// <summary>Sends a state, and has one of the two callbacks run once in a later Poll.</summary>
        /// <param name="state">Its public fields and properties are sent, as JSON of at most 65,536 bytes.</param>
        /// <param name="reply">Gets what the server has answered.</param>
        /// <param name="error">Gets the reason why there is no such answer: also a text that begins with
        /// <c>error:</c>, and a reply that does not fit TOrder.</param>
        /// <exception cref="ArgumentException">The state is too long.</exception>
        /// <exception cref="JsonException">The state cannot be written as JSON, which has no NaN and no
        /// Infinity.</exception>
        /// <returns>False if refused: neither callback will run.</returns>
        public static bool Ask<TState, TOrder>(this BackgroundClient client, TState state, Action<TOrder> reply,
            Action<string> error) where TOrder : new()
        {
            return client.Request(JsonConvert.SerializeObject(state, Rules), text =>
            {
                TOrder order;
                try { order = Read<TOrder>(text); }
                catch (GaveUpException e) { error?.Invoke(e.Message); return; }
                reply?.Invoke(order);
            }, error);
        }

        /// <summary>The same to await: <c>await client.AskAsync&lt;State, Order&gt;(state,
        /// destroyCancellationToken)</c>. The awaiting method goes on inside Poll.</summary>
        /// <exception cref="GaveUpException">The server has answered <c>error: …</c>, or what does not fit TOrder; or
        /// the request was refused.</exception>
        /// <exception cref="TimeoutException">There is no answer. RequestAsync has the other exceptions.</exception>
        public static async Task<TOrder> AskAsync<TState, TOrder>(this BackgroundClient client, TState state,
            CancellationToken cancel = default) where TOrder : new() =>
            Read<TOrder>(await client.RequestAsync(JsonConvert.SerializeObject(state, Rules), cancel));

        private static TOrder Read<TOrder>(string reply)
        {
            if (reply.StartsWith("error:", StringComparison.Ordinal)) throw new GaveUpException(reply);
            try
            {
                // Of null and of an empty text Newtonsoft makes null.
                var order = JsonConvert.DeserializeObject<TOrder>(reply, Rules);
                return order is null ? throw new JsonSerializationException("It is no object.") : order;
            }
            catch (Exception e)
            {
                // Of Newtonsoft's texts of several lines the first says what is wrong, and the last where.
                var lines = e.Message.Split('\n');
                var trouble = lines.Length > 1 ? $"{lines[0].Trim()} {lines[^1]}" : e.Message;
                var why = $"the reply {LogText.Printable(reply, 80)} does not fit {typeof(TOrder).Name}: {trouble}";
                throw new GaveUpException(LogText.Printable(why, 400));
            }
        }

        // Newtonsoft would write NaN and Infinity as texts, and Python would go on with them.
        private sealed class FiniteNumbers : JsonConverter
        {
            public override bool CanConvert(Type type) =>
                type == typeof(float) || type == typeof(double) || type == typeof(float?) || type == typeof(double?);

            public override object ReadJson(JsonReader reader, Type type, object old, JsonSerializer serializer) =>
                Checked(JToken.ReadFrom(reader).ToObject(type), reader.Path);

            public override void WriteJson(JsonWriter writer, object value, JsonSerializer serializer) =>
                writer.WriteValue(Checked(value, writer.Path));

            private static object Checked(object number, string path)
            {
                var value = Convert.ToDouble(number, CultureInfo.InvariantCulture);
                if (!double.IsNaN(value) && !double.IsInfinity(value)) return number;
                throw new JsonSerializationException(
                    FormattableString.Invariant($"{value} is not JSON. Path '{path}'."));
            }
        }

        // A Vector3 is its x, y and z: its property `normalized` is a Vector3, which has such a property again.
        private sealed class UnityFields : DefaultContractResolver
        {
            protected override List<MemberInfo> GetSerializableMembers(Type type)
            {
                var all = base.GetSerializableMembers(type);
                var fields = all.FindAll(each => each is FieldInfo);
                return type.Namespace == "UnityEngine" && fields.Count > 0 ? fields : all;
            }
        }
    }
}
