// Lesson 11 in Unity, a scene that is loaded while Python steps: its GymManager takes the connection of the one before.
using UnityEngine;
using UnityEngine.SceneManagement;

namespace NetMQExample
{
    /// <summary>Between the end of one GymManager and the beginning of the next one.</summary>
    internal static class SceneChange
    {
        private static GymManager leaving;

        /// <summary>Whether a scene is being loaded: that is the last one then.</summary>
        public static bool Loads() => !SceneManager.GetSceneAt(SceneManager.sceneCount - 1).isLoaded;

        /// <summary>Its scene is left. If none of the next scene takes its place, it ends.</summary>
        public static void Leave(GymManager manager)
        {
            leaving = manager;
            // Unity raises it after the OnEnable of what is in the scene.
            SceneManager.sceneLoaded += Loaded;
        }

        /// <summary>The one before, or null.</summary>
        public static GymManager Take()
        {
            SceneManager.sceneLoaded -= Loaded;
            var before = leaving;
            leaving = null;
            return before;
        }

        private static void Loaded(Scene scene, LoadSceneMode mode)
        {
            var left = Take();
            if (left is null) return;
            Debug.LogWarning(
                $"trouble: {scene.name} has no GymManager with the Env Name {left.EnvName}: Python has lost it");
            left.Leave();
        }
    }
}
