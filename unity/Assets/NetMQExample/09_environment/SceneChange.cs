// Lesson 09 in Unity, a scene that is loaded while Python steps: its GymManager takes the connection of the one before.
using System;
using System.Collections.Generic;
using UnityEngine;
using UnityEngine.SceneManagement;

namespace NetMQExample
{
    /// <summary>Between the end of one GymManager and the beginning of the next one.</summary>
    internal static class SceneChange
    {
        private static readonly List<(GymManager Manager, string Endpoint, string Name, Action Leave)> Leaving =
            new List<(GymManager, string, string, Action)>();

        /// <summary>Whether a scene is being loaded: that is the last one then.</summary>
        public static bool Loads() => !SceneManager.GetSceneAt(SceneManager.sceneCount - 1).isLoaded;

        /// <summary>Its scene is left. If none of the next scene takes its place, it ends.</summary>
        public static void Leave(GymManager manager, string endpoint, string name, Action leave)
        {
            Leaving.Add((manager, endpoint, name, leave));
            // Unity raises it after the OnEnable of what is in the scene.
            SceneManager.sceneLoaded -= Loaded;
            SceneManager.sceneLoaded += Loaded;
        }

        /// <summary>The one before, or null.</summary>
        public static GymManager Take(string endpoint, string name)
        {
            var at = Leaving.FindIndex(one => one.Endpoint == endpoint && one.Name == name);
            if (at < 0) return null;
            var found = Leaving[at].Manager;
            Leaving.RemoveAt(at);
            return found;
        }

        private static void Loaded(Scene scene, LoadSceneMode mode)
        {
            SceneManager.sceneLoaded -= Loaded;
            foreach (var (_, _, name, leave) in Leaving.ToArray())
            {
                Debug.LogWarning(
                    $"trouble: {scene.name} has no GymManager with the Env Name {name}: Python has lost it");
                leave();
            }
            Leaving.Clear();
        }
    }
}
