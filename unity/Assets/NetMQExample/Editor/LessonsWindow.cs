// Tools > NetMQ Example > Lessons: a lesson's Python server, its scene, and what is missing on this machine, without a
// terminal.
using System;
using System.ComponentModel;
using System.IO;
using UnityEditor;
using UnityEditor.SceneManagement;
using UnityEngine;

namespace NetMQExample.Editor
{
    /// <summary>The window in which servers are started and stopped.</summary>
    internal sealed class LessonsWindow : EditorWindow
    {
        private const string Menu = "Tools/NetMQ Example/", Kit = "NetMQExample.kit", Copies = "NetMQExample scenes";
        // Of this project alone, and not emptied when the editor ends.
        private static readonly string Log = Path.GetFullPath("Library/NetMQExample/server.log");

        private static LessonServer server;

        // Serialized, so that a reload of the scripts leaves them as they are.
        [SerializeField] private int chosen;
        [SerializeField] private string options = "";
        [SerializeField] private Vector2 scrolled;

        private Checkout kit;
        private string[] lessons;
        private string trouble = "", lines = "";
        private bool running;

        [MenuItem(Menu + "Lessons", false, 0)]
        public static void Open() => GetWindow<LessonsWindow>("NetMQ lessons");

        // Also without the window: the server ends with the editor, whoever has closed what.
        [InitializeOnLoadMethod]
        private static void Load()
        {
            // Unity's processes that import assets load these scripts too, and end when they please.
            if (AssetDatabase.IsAssetImportWorkerProcess()) return;
            server = LessonServer.Find(Log);
            EditorApplication.quitting += () =>
            {
                server?.Stop();
                // The next editor begins with no lines, unless this one does not get here.
                if (server != null) File.Delete(Log);
            };
        }

        // Of this file, wherever the package lies.
        private string Script => AssetDatabase.GetAssetPath(MonoScript.FromScriptableObject(this));

        private void OnEnable()
        {
            kit = Checkout.Find(Path.GetFullPath(Script), EditorPrefs.GetString(Kit, ""));
            lessons = kit?.Lessons;
        }

        // Ten times a second, and not while it is drawn: between layout and drawing nothing may change.
        private void OnInspectorUpdate()
        {
            var before = lines;
            lines = server?.Lines ?? "";
            running = server?.Running == true;
            // To the end: the newest line is the one to read.
            if (lines != before) scrolled.y = float.MaxValue;
            Repaint();
        }

        private void OnGUI()
        {
            if (kit == null)
            {
                EditorGUILayout.HelpBox("The Python servers are not in this project: they are in the kit that this "
                    + "package came from. Choose its folder, the one with kit.py in it.", MessageType.Warning);
                if (!GUILayout.Button("Choose the kit's folder")) return;
                EditorPrefs.SetString(Kit, EditorUtility.OpenFolderPanel("The folder with kit.py", "", ""));
                OnEnable();
                return;
            }
            chosen = EditorGUILayout.Popup("Lesson", Math.Min(chosen, lessons.Length - 1), lessons);
            options = EditorGUILayout.TextField("Options of its server", options);
            if (running)
            {
                if (GUILayout.Button("Stop the server")) server.Stop();
            }
            else
            {
                if (GUILayout.Button("Start the server")) Launch(kit.Server(lessons[chosen]), options);
                // It also says whether the ports are free: that is to be asked while no server has one.
                if (GUILayout.Button("Run doctor")) Launch(Path.Combine(kit.Root, "kit.py"), "doctor");
            }
            if (GUILayout.Button("Copy the pip line"))
                EditorGUIUtility.systemCopyBuffer = kit.PipLine(kit.Python(out trouble) ?? "python3", lessons[chosen]);
            DrawScene();
            if (trouble.Length > 0) EditorGUILayout.HelpBox(trouble, MessageType.Error);
            scrolled = EditorGUILayout.BeginScrollView(scrolled);
            // A text area, so that lines can be selected and copied.
            EditorGUILayout.TextArea(lines, GUILayout.ExpandHeight(true));
            EditorGUILayout.EndScrollView();
        }

        private void DrawScene()
        {
            var folder = Path.GetDirectoryName(Path.GetDirectoryName(Script));
            var scene = $"{folder}/{lessons[chosen]}/{lessons[chosen]}.unity".Replace('\\', '/');
            // Unity opens no scene while it plays.
            if (scene.StartsWith("Assets/") && !File.Exists(scene) || EditorApplication.isPlaying) return;
            if (GUILayout.Button("Open its scene") && EditorSceneManager.SaveCurrentModifiedScenesIfUserWantsTo())
                EditorSceneManager.OpenScene(Writable(scene));
        }

        // Nor one of a package that it has fetched by an address, which is read-only: there a copy takes its place.
        private static string Writable(string scene)
        {
            if (scene.StartsWith("Assets/")) return scene;
            var copy = $"Assets/{Copies}/{Path.GetFileName(scene)}";
            if (!AssetDatabase.IsValidFolder($"Assets/{Copies}")) AssetDatabase.CreateFolder("Assets", Copies);
            if (!File.Exists(copy)) AssetDatabase.CopyAsset(scene, copy);
            return copy;
        }

        private void Launch(string script, string words)
        {
            // The second half of a double click.
            if (server?.Running == true) return;
            var python = kit.Python(out trouble);
            // Doctor runs without pyzmq, and says so itself.
            if (python == null || (trouble.Length > 0 && words != "doctor")) return;
            try
            {
                server = LessonServer.Start(python, script, words, kit.Folder(lessons[chosen]), Log);
            }
            catch (Exception e) when (e is IOException || e is UnauthorizedAccessException)
            {
                trouble = $"could not start {python}: {e.Message}";
            }
            // It has answered just now: hence it is the options.
            catch (Win32Exception) { trouble = $"could not start with the options {words}: is each \" and ' closed?"; }
        }
    }
}
