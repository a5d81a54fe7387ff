// The editor's work with assets, scenes and the objects in them.
using System;
using System.IO;
using System.Linq;
using UnityEngine;
using UnityEngine.UIElements;
using Object = UnityEngine.Object;

namespace UnityEditor
{
    [AttributeUsage(AttributeTargets.Class, AllowMultiple = true)]
    public class CustomEditor : Attribute
    {
        public CustomEditor(Type inspectedType, bool editorForChildClasses) { }
    }

    [AttributeUsage(AttributeTargets.Class)]
    public sealed class CanEditMultipleObjects : Attribute { }

    public class Editor : ScriptableObject
    {
        public Object target => targets[0];
        public Object[] targets { get; internal set; }
        public SerializedObject serializedObject { get; } = new SerializedObject();
        public virtual VisualElement CreateInspectorGUI() => null;
        public virtual bool RequiresConstantRepaint() => false;
    }

    public sealed class MenuCommand
    {
        public Object context;

        public MenuCommand(Object inContext) => context = inContext;
    }

    public class MonoScript : TextAsset
    {
        internal Type Class { get; set; }

        public static MonoScript FromScriptableObject(ScriptableObject scriptableObject) =>
            new MonoScript { Class = scriptableObject.GetType() };
    }

    public sealed class AssetDatabase
    {
        /// <summary>Where the package lies: Assets/NetMQExample or Packages/com.netmqexample.lessons.</summary>
        internal static string Package { get; set; } = "Assets/NetMQExample";
        public static bool IsAssetImportWorkerProcess() => false;

        public static string GetAssetPath(Object assetObject) =>
            assetObject is MonoScript script ? $"{Package}/Editor/{script.Class.Name}.cs" : "";

        public static string GUIDToAssetPath(string guid) =>
            Directory.GetFiles(Package, "*.meta", SearchOption.AllDirectories)
                .Where(file => File.ReadAllText(file).Contains($"guid: {guid}"))
                .Select(file => file.Substring(0, file.Length - ".meta".Length)).FirstOrDefault() ?? "";

        public static T LoadAssetAtPath<T>(string assetPath) where T : Object =>
            File.Exists(assetPath) ? new GameObject(Path.GetFileNameWithoutExtension(assetPath)) as T : null;

        public static bool IsValidFolder(string path) => Directory.Exists(path);

        public static string CreateFolder(string parentFolder, string newFolderName)
        {
            Directory.CreateDirectory($"{parentFolder}/{newFolderName}");
            return "";
        }

        public static bool CopyAsset(string path, string newPath)
        {
            File.Copy(path, newPath);
            return true;
        }

        public static void CreateAsset(Object asset, string path)
        {
            Drawing.Lines.Add($"created {path}");
            Resources.Assets[Path.GetFileNameWithoutExtension(path)] = asset;
        }
    }

    public sealed class PrefabUtility
    {
        public static Object InstantiatePrefab(Object assetComponentOrGameObject) => assetComponentOrGameObject;
    }

    public sealed class GameObjectUtility
    {
        public static void SetParentAndAlign(GameObject child, GameObject parent)
        {
            if (parent != null) child.transform.SetParent(parent.transform, false);
        }
    }

    public class Undo
    {
        public static void RegisterCreatedObjectUndo(Object objectToUndo, string name) =>
            Drawing.Lines.Add($"undo: {name}");
    }

    public sealed class Selection
    {
        public static Object activeObject { get; set; }
    }
}

namespace UnityEditor.SceneManagement
{
    public sealed class EditorSceneManager : UnityEngine.SceneManagement.SceneManager
    {
        public static bool SaveCurrentModifiedScenesIfUserWantsTo() => true;

        public static UnityEngine.SceneManagement.Scene OpenScene(string scenePath)
        {
            Drawing.Lines.Add($"opened {scenePath}");
            return default;
        }
    }
}

namespace UnityEngine
{
    public class TextAsset : Object { }
}
