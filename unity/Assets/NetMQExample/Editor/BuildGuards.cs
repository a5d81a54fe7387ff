// Warns of a build for a device, and adds to it: the checklist of docs/guide/devices.md, as far as a
// program can go through it.
using System;
using System.ComponentModel;
using System.Diagnostics;
using System.IO;
using System.Text.RegularExpressions;
using UnityEditor;
using UnityEditor.Build;
using UnityEditor.Build.Reporting;
using UnityEditor.Callbacks;
using UnityEditor.UnityLinker;
using UnityEngine;
using UnityEngine.SceneManagement;
using Debug = UnityEngine.Debug;

namespace NetMQExample.Editor
{
    /// <summary>Unity calls it at each build.</summary>
    internal sealed class BuildGuards : IPreprocessBuildWithReport, IProcessSceneWithReport, IUnityLinkerProcessor
    {
        // link.xml, wherever the package lies.
        private const string Link = "c6fd050a2b57f54e58f156fa95262044";

        private const string Permission = "Android may refuse NetMQ the network: set Project Settings, Player, Other "
            + "Settings, Internet Access to Require";

        private const string Ask = "from Android 17 on the user decides whether a game may talk to the local network: "
            + "declare android.permission." + Access + " in " + Manifest + ", and ask for it with "
            + "UnityEngine.Android.Permission.RequestUserPermission";

        private const string Access = "ACCESS_LOCAL_NETWORK";
        private const string Manifest = "Assets/Plugins/Android/AndroidManifest.xml";
        private const string Key = "NSLocalNetworkUsageDescription";

        public int callbackOrder => 0;

        // Adds to a build for a system of Apple's, an Xcode project or a Mac's program, the sentence that its user is
        // asked with. Early: whoever signs a build of their own does so after.
        [PostProcessBuild(-100)]
        public static void AddNetworkSentence(BuildTarget target, string pathToBuiltProject)
        {
            var mac = target == BuildTarget.StandaloneOSX;
            var program = mac && pathToBuiltProject.EndsWith(".app", StringComparison.Ordinal);
            var folder = program ? "Contents" : mac ? PlayerSettings.productName : "";
            var path = Path.Combine(pathToBuiltProject, folder, "Info.plist");
            if (!(mac || IsDevice(target)) || !File.Exists(path)) return;
            var before = File.ReadAllText(path);
            var after = WithNetworkSentence(before);
            if (after == before) return;
            File.WriteAllText(path, after);
            if (program) Sign(pathToBuiltProject);
        }

        // Unity has signed what it was. Its own class for this is in a module that only some editors have, and in the
        // others a script that names it does not compile.
        private static void Sign(string program)
        {
            var start = new ProcessStartInfo("codesign", $"--force --deep --sign - \"{program}\"");
            start.UseShellExecute = false;
            try
            {
                using var codesign = Process.Start(start);
                codesign.WaitForExit();
                if (codesign.ExitCode != 0)
                    Debug.LogError($"{Path.GetFileName(program)} is not signed: codesign {start.Arguments} failed");
            }
            catch (Win32Exception)
            {
                Debug.Log($"on a Mac, before {Path.GetFileName(program)} runs: codesign {start.Arguments}");
            }
        }

        public void OnPreprocessBuild(BuildReport report)
        {
            if (report.summary.platform != BuildTarget.Android) return;
            if (!PlayerSettings.Android.forceInternetPermission) Debug.LogWarning(Permission);
            if (MustAsk((int)PlayerSettings.Android.targetSdkVersion)) Debug.LogWarning(Ask);
        }

        public void OnProcessScene(Scene scene, BuildReport report)
        {
            // Without a report it is a Play.
            if (report == null || !IsDevice(report.summary.platform)) return;
            foreach (var root in scene.GetRootGameObjects())
                foreach (var client in root.GetComponentsInChildren<ConnectedBehaviour>(true))
                    if (IsLoopback(ServerAddress.Of(client)))
                        Debug.LogWarning(Loopback(scene.name, client.GetType().Name), client);
        }

        // Unity reads no link.xml of a package by itself.
        public string GenerateAdditionalLinkXmlFile(BuildReport report, UnityLinkerBuildPipelineData data)
        {
            var path = AssetDatabase.GUIDToAssetPath(Link);
            // A project without it has one of its own.
            return path.Length > 0 ? Path.GetFullPath(path) : null;
        }

        // VisionOS by its name: Unity 2021 has none.
        private static bool IsDevice(BuildTarget target) =>
            target == BuildTarget.Android || target == BuildTarget.iOS || $"{target}" == "VisionOS";

        // An API level of 0 is the newest one installed, whichever that is.
        private static bool MustAsk(int target) =>
            target >= 37 && !(File.Exists(Manifest) && File.ReadAllText(Manifest).Contains(Access));

        private static bool IsLoopback(string endpoint) =>
            Regex.IsMatch(endpoint ?? "", @"^tcp://(127\.\d+\.\d+\.\d+|localhost):");

        private static string Loopback(string scene, string client) =>
            $"{client} in scene {scene} asks 127.0.0.1, which on a device is the device itself: write your computer's "
            + "address into Tools, NetMQ Example, Server address";

        // Apple's systems say this when a game wants to talk to the network.
        private static string WithNetworkSentence(string plist) => plist.Contains($"<key>{Key}</key>")
            ? plist
            : new Regex("<dict>").Replace(plist, $"<dict>\n\t<key>{Key}</key>\n"
                + "\t<string>This game talks to a computer on your network.</string>", 1);
    }
}
