// Unity calls these when it builds a game.
using System;
using UnityEngine.SceneManagement;

namespace UnityEditor
{
    public enum BuildTarget
    {
        StandaloneOSX = 2,
        iOS = 9,
        Android = 13,
        StandaloneLinux64 = 24,
        VisionOS = 47,
    }

    public enum AndroidSdkVersions
    {
        AndroidApiLevelAuto = 0,
        AndroidApiLevel36 = 36,
    }

    public sealed class PlayerSettings : UnityEngine.Object
    {
        private PlayerSettings() { }
        public static string productName { get; set; } = "My Game";

        public class Android
        {
            public static bool forceInternetPermission { get; set; }
            public static AndroidSdkVersions targetSdkVersion { get; set; }
        }
    }
}

namespace UnityEditor.Build
{
    public interface IOrderedCallback
    {
        int callbackOrder { get; }
    }

    public interface IPreprocessBuildWithReport : IOrderedCallback
    {
        void OnPreprocessBuild(Reporting.BuildReport report);
    }

    public interface IProcessSceneWithReport : IOrderedCallback
    {
        void OnProcessScene(Scene scene, Reporting.BuildReport report);
    }

    public interface IUnityLinkerProcessor : IOrderedCallback
    {
        string GenerateAdditionalLinkXmlFile(
            Reporting.BuildReport report, UnityLinker.UnityLinkerBuildPipelineData data);
    }
}

namespace UnityEditor.Build.Reporting
{
    public sealed class BuildReport : UnityEngine.Object
    {
        internal BuildReport(BuildTarget platform) => summary = new BuildSummary(platform);
        public BuildSummary summary { get; }
    }

    public struct BuildSummary
    {
        internal BuildSummary(BuildTarget platform) => this.platform = platform;
        public BuildTarget platform { get; }
    }
}

namespace UnityEditor.Callbacks
{
    public abstract class CallbackOrderAttribute : Attribute { }

    public sealed class PostProcessBuildAttribute : CallbackOrderAttribute
    {
        public PostProcessBuildAttribute(int callbackOrder) { }
    }
}

namespace UnityEditor.UnityLinker
{
    public sealed class UnityLinkerBuildPipelineData
    {
        internal UnityLinkerBuildPipelineData() { }
    }
}
