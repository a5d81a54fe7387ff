// What is said of a build for a device, and what is written into it.
using System.IO;
using System.Text.RegularExpressions;

namespace NetMQExample.Editor
{
    /// <summary>The rules behind <see cref="BuildGuards"/>.</summary>
    internal static class DeviceChecks
    {
        public const string Permission = "Android may refuse NetMQ the network: set Project Settings, Player, Other "
            + "Settings, Internet Access to Require";

        public const string Ask = "from Android 17 on the user decides whether a game may talk to the local network: "
            + "declare android.permission." + Access + " in " + Manifest + ", and ask for it with "
            + "UnityEngine.Android.Permission.RequestUserPermission";

        private const string Access = "ACCESS_LOCAL_NETWORK";
        private const string Manifest = "Assets/Plugins/Android/AndroidManifest.xml";
        private const string Key = "NSLocalNetworkUsageDescription";

        /// <summary>Whether an Android build of this API level must ask for the local network, and does not declare it.
        /// Level 0 is the newest one installed, whichever that is.</summary>
        public static bool MustAsk(int target) =>
            target >= 37 && !(File.Exists(Manifest) && File.ReadAllText(Manifest).Contains(Access));

        /// <summary>Whether an endpoint, which may be null, means the machine that the game itself runs on.</summary>
        public static bool IsLoopback(string endpoint) =>
            Regex.IsMatch(endpoint ?? "", @"^tcp://(127\.\d+\.\d+\.\d+|localhost):");

        public static string Loopback(string scene, string client) =>
            $"{client} in scene {scene} asks 127.0.0.1, which on a device is the device itself: write your computer's "
            + "address into Tools, NetMQ Example, Server address";

        /// <summary>An Info.plist with what Apple's systems say when a game wants to talk to the network.</summary>
        public static string WithNetworkSentence(string plist) => plist.Contains($"<key>{Key}</key>")
            ? plist
            : new Regex("<dict>").Replace(plist, $"<dict>\n\t<key>{Key}</key>\n"
                + "\t<string>This game talks to a computer on your network.</string>", 1);
    }
}
