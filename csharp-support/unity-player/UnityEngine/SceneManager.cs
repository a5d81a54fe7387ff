// The one scene that a Play has, which may be loaded anew.
using System;
using System.Linq;

namespace UnityEngine.SceneManagement
{
    public enum LoadSceneMode { Single, Additive }

    public readonly struct Scene
    {
        internal Scene(bool loaded) => isLoaded = loaded;
        public bool isLoaded { get; }
        public string name => SceneManager.Name;
        public int buildIndex => 0;
        public GameObject[] GetRootGameObjects() =>
            LoadedScene.Objects.Where(thing => thing.transform.parent == null).ToArray();
    }

    public class SceneManager
    {
        internal const string Name = "Main";
        private static bool asked;
        public static event Events.UnityAction<Scene, LoadSceneMode> sceneLoaded;
        // One that is being loaded is there as well, behind all others.
        public static int sceneCount => asked ? 2 : 1;
        internal static Action Make { get; set; }
        public static Scene GetActiveScene() => new Scene(true);

        public static Scene GetSceneAt(int index)
        {
            MainThread.Only(nameof(GetSceneAt));
            return new Scene(index == 0);
        }

        public static void LoadScene(string sceneName) => LoadScene(sceneName, LoadSceneMode.Single);

        public static void LoadScene(string sceneName, LoadSceneMode mode)
        {
            if (sceneName != Name)
                throw new NotSupportedException(
                    $"the player has one scene, {Name}: SceneManager.GetActiveScene().name");
            LoadScene(0, mode);
        }

        public static void LoadScene(int sceneBuildIndex) => LoadScene(sceneBuildIndex, LoadSceneMode.Single);

        /// <summary>Takes effect at the beginning of the next frame.</summary>
        public static void LoadScene(int sceneBuildIndex, LoadSceneMode mode)
        {
            MainThread.Only(nameof(LoadScene));
            if (mode != LoadSceneMode.Single || sceneBuildIndex != 0)
                throw new NotSupportedException("the player has one scene, with the index 0");
            asked = true;
        }

        internal static void Change()
        {
            if (!asked) return;
            foreach (var thing in LoadedScene.Objects.Where(
                thing => !LoadedScene.Kept.Contains(thing.transform.root.gameObject)).ToArray())
                if (thing != null) LoadedScene.Remove(thing);
            Make();
            asked = false;
            sceneLoaded?.Invoke(GetActiveScene(), LoadSceneMode.Single);
        }
    }
}
