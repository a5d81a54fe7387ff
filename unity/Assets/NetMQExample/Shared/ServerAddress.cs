// Where the servers are, said once for a whole game: by an asset, or on the command line of a build.
//
//     Tools > NetMQ Example > Server address       makes the asset; its host takes the place of 127.0.0.1 everywhere
//     MyGame.exe --endpoint tcp://192.168.1.20:5554                this Play's endpoint, whatever the scene says
//     MyGame.exe --ViewRecorder.endpoint tcp://192.168.1.20:5562   that of one class, whatever the others have
//
// Without asset and option the fields of the components count.
using System;
using System.Linq;
using System.Text.RegularExpressions;
using UnityEngine;
using Object = UnityEngine.Object;

namespace NetMQExample
{
    /// <summary>An asset in a folder Resources, named like <see cref="File"/>.</summary>
    public sealed class ServerAddress : ScriptableObject
    {
        public const string File = "NetMQServerAddress";

        [SerializeField, Tooltip("The servers' machine, such as 192.168.1.20, or beacon://NAME to look for it")]
        private string host = "127.0.0.1";

        /// <summary>The endpoint that a component will connect to.</summary>
        /// <param name="component">One with a serialized field of this name.</param>
        /// <returns>An endpoint, or null if it has none.</returns>
        public static string Of(Object component)
        {
            string own;
            // Unity's own serializer reaches private fields, also where IL2CPP leaves out reflection's data.
            try { own = JsonUtility.FromJson<Field>(JsonUtility.ToJson(component)).endpoint; }
            // NaN in another field is no JSON. The component says so itself when it checks its fields.
            catch (ArgumentException) { return null; }
            var asset = Resources.Load<ServerAddress>(File);
            var words = Environment.GetCommandLineArgs();
            return Choose(own, asset == null ? "" : asset.host, words, component.GetType().Name);
        }

        /// <summary>Writes it into the field. Not while a scene is edited: it would be saved.</summary>
        /// <param name="component">One with a serialized field of this name.</param>
        public static void Apply(Object component)
        {
            var endpoint = Of(component);
            if (endpoint == null) return;
            JsonUtility.FromJsonOverwrite(JsonUtility.ToJson(new Field { endpoint = endpoint }), component);
        }

        private static string Choose(string own, string host, string[] words, string type)
        {
            if (string.IsNullOrEmpty(own)) return null;
            // The last one counts, and one word is as good as two: as in Python.
            int At(string option) => Array.FindLastIndex(words, word => Regex.IsMatch(word, $"^--{option}(=|$)"));
            var at = At($@"{type}\.endpoint");
            // An environment that has launched the game awaits its views there.
            var views = type == "ViewRecorder" ? Environment.GetEnvironmentVariable("NETMQ_EXAMPLE_VIEWS") : "";
            if (at < 0 && !string.IsNullOrEmpty(views)) return views;
            if (at < 0) at = At("endpoint");
            if (at >= 0 && words[at].Contains("=")) return words[at].Split('=')[1];
            if (at >= 0) return words.ElementAtOrDefault(at + 1) ?? "";
            // Another machine in a field is meant.
            if (host.Length == 0) return own;
            var place = host.StartsWith("beacon://", StringComparison.Ordinal) ? host : $"tcp://{host}";
            return Regex.Replace(own, @"^tcp://(127\.0\.0\.1|localhost)(?=:)", place);
        }

        [Serializable]
        private sealed class Field
        {
            public string endpoint;
        }
    }
}
