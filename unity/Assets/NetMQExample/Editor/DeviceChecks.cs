// What is said of a build for a device, and what is written into it.
using System.IO;
using System.Text.RegularExpressions;

namespace NetMQExample.Editor
{
    /// <summary>The rules behind <see cref="BuildGuards"/>.</summary>
    public static class DeviceChecks
    {
        /// <summary>Said of Android.</summary>
        public const string Permission = "Android may refuse NetMQ the network: set Project Settings, Player, Other "
            + "Settings, Internet Access to Require";

        /// <summary>Said of Android 17.</summary>
        public const string Ask = "from Android 17 on the user decides whether a game may talk to the local network: "
            + "declare android.permission." + Access + " in " + Manifest + ", and ask for it with "
            + "UnityEngine.Android.Permission.RequestUserPermission";

        private const string Access = "ACCESS_LOCAL_NETWORK";
        private const string Manifest = "Assets/Plugins/Android/AndroidManifest.xml";
        private const string Key = "NSLocalNetworkUsageDescription";

        /// <summary>Whether an Android build must ask for the local network, and does not declare it.</summary>
        /// <param name="target">Its API level; 0 is the newest one installed, whichever that is.</param>
        /// <returns>True if <see cref="Ask"/> is to be said.</returns>
        public static bool MustAsk(int target) =>
            target >= 37 && !(File.Exists(Manifest) && File.ReadAllText(Manifest).Contains(Access));

        /// <summary>Whether an endpoint means the machine that the game itself runs on.</summary>
        /// <param name="endpoint">Such as tcp://127.0.0.1:5554, or null.</param>
        /// <returns>True for any of this machine's names for itself.</returns>
        public static bool IsLoopback(string endpoint) =>
            Regex.IsMatch(endpoint ?? "", @"^tcp://(127\.\d+\.\d+\.\d+|localhost):");

        /// <summary>The warning about one.</summary>
        /// <param name="scene">Where it is.</param>
        /// <param name="client">Whose it is.</param>
        /// <returns>Cause and cure.</returns>
        public static string Loopback(string scene, string client) =>
            $"{client} in scene {scene} asks 127.0.0.1, which on a device is the device itself: write your computer's "
            + "address into Tools, NetMQ Example, Server address";

        /// <summary>Adds what Apple's systems show when a game wants to talk to the local network, if nothing is
        /// there.</summary>
        /// <param name="plist">The text of an Info.plist.</param>
        /// <returns>The same, with the sentence.</returns>
        public static string WithNetworkSentence(string plist) => plist.Contains($"<key>{Key}</key>")
            ? plist
            : new Regex("<dict>").Replace(plist, $"<dict>\n\t<key>{Key}</key>\n"
                + "\t<string>This game talks to a computer on your network.</string>", 1);
    }
}
