// GameObject > NetMQ Example, and the asset that says where the servers are.
using UnityEditor;
using UnityEngine;

namespace NetMQExample.Editor
{
    internal static class ClientMenu
    {
        // BackgroundClient.prefab, wherever the package lies.
        private const string Prefab = "59c6f48fc3213eb99066528821de5097";

        // Lesson 04's client with a display, below the object that is selected.
        [MenuItem("GameObject/NetMQ Example/Background client", false, 10)]
        public static void AddClient(MenuCommand command)
        {
            var prefab = AssetDatabase.LoadAssetAtPath<GameObject>(AssetDatabase.GUIDToAssetPath(Prefab));
            var made = (GameObject)PrefabUtility.InstantiatePrefab(prefab);
            GameObjectUtility.SetParentAndAlign(made, command.context as GameObject);
            Undo.RegisterCreatedObjectUndo(made, "Add NetMQ client");
            Selection.activeObject = made;
        }

        // The asset with the servers' address, which is made the first time.
        [MenuItem("Tools/NetMQ Example/Server address", false, 2)]
        public static void OpenAddress()
        {
            var asset = Resources.Load<ServerAddress>(ServerAddress.File);
            if (asset == null)
            {
                if (!AssetDatabase.IsValidFolder("Assets/Resources")) AssetDatabase.CreateFolder("Assets", "Resources");
                asset = ScriptableObject.CreateInstance<ServerAddress>();
                AssetDatabase.CreateAsset(asset, $"Assets/Resources/{ServerAddress.File}.asset");
            }
            Selection.activeObject = asset;
        }
    }
}
