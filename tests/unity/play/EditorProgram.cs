// Does in the editor what a line of the standard input says, and prints what is drawn then.
//
//     references DLL          which assemblies it names
//     package PATH            where the package lies; folder PATH: what is chosen when a folder is asked for
//     load                    what Unity does after each reload of the scripts
//     menu ITEM               such as Tools/NetMQ Example/Lessons
//     type LABEL=TEXT         into a field; press BUTTON; twice BUTTON, before the window looks again
//     draw                    the windows, once; after a frame, if it plays
//     play 4 ENDPOINT COUNT   a lesson's scripts, with the first one's inspector; stop
//     another ENDPOINT        one more of it, and both are selected; prefab: it is one in Assets; destroy it
//     host ADDRESS            into the asset with the servers' address
//     build TARGET FOLDER     what Unity calls when it builds for a platform; build Android FOLDER 37: for that API
//                             level
//     forget 2                so many clients of a script's that are never disposed; remember: they are after all;
//                             settle: the others are
//     counted                 whether a program that is not compiled for the editor shows its messages
//     quit                    the end of the editor
//
// The calls of NetMQConnection.Show here are compiled as in a build; the folder Editor beside it is not.
#undef UNITY_EDITOR
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using System.Reflection;
using System.Threading;
using NetMQ.Sockets;
using NetMQExample.Editor;
using NetMQExample.PlayTest;
using UnityEditor;
using UnityEditor.Build.Reporting;
using UnityEngine;
using UnityEngine.UIElements;
using UnityPlayer;
using Drawing = UnityEditor.Drawing;
using Object = UnityEngine.Object;

namespace NetMQExample.EditorTest
{
    internal static class EditorProgram
    {
        private const BindingFlags Any = BindingFlags.Instance | BindingFlags.Static | BindingFlags.Public
            | BindingFlags.NonPublic;
        private static readonly Assembly Package = typeof(LessonServer).Assembly;
        private static readonly Stack<NetMQLifetime> Forgotten = new Stack<NetMQLifetime>();
        private static Player player;
        private static ClientInspector inspector;
        private static VisualElement drawn;
        private static TextMesh shown;

        public static int Run()
        {
            GUI.Pressed = Drawing.Button;
            Console.WriteLine("ready");
            for (var line = Console.ReadLine(); line != null; line = Console.ReadLine())
            {
                var words = line.Split(new[] { ' ' }, 2);
                Do(words[0], words.Length > 1 ? words[1] : "");
                Console.WriteLine($"did {line}");
                if (line == "quit") break;
            }
            return 0;
        }

        private static void Do(string what, string with)
        {
            switch (what)
            {
                case "references":
                    foreach (var one in Assembly.LoadFile(with).GetReferencedAssemblies()) Console.WriteLine(one.Name);
                    break;
                case "package": AssetDatabase.Package = with; break;
                case "folder": EditorUtility.Chosen = with; break;
                case "load": Call<InitializeOnLoadMethodAttribute>(_ => true); break;
                case "menu": Call<MenuItem>(item => item.menuItem == with); break;
                case "type": Drawing.Typed[with.Split('=')[0]] = with.Split(new[] { '=' }, 2)[1]; break;
                case "press": Draw(with); break;
                case "twice": Draw(with, 2); break;
                case "draw": Draw(""); break;
                case "clipboard": Console.WriteLine(EditorGUIUtility.systemCopyBuffer); break;
                case "play": Play(with.Split(' ')); break;
                case "stop": Stop(); break;
                case "another": Another(with); break;
                case "prefab": EditorUtility.Assets.Add(inspector.target); break;
                case "destroy": Object.DestroyImmediate(((Component)inspector.target).gameObject); break;
                case "host": SetHost(with); break;
                case "build": Build(with.Split(' ')); break;
                case "forget":
                    for (var i = int.Parse(with, CultureInfo.InvariantCulture); i > 0; i--)
                        Forgotten.Push(new NetMQLifetime());
                    break;
                case "settle": while (NetMQLifetime.Users > Forgotten.Count) Thread.Sleep(5); break;
                case "remember": while (Forgotten.Count > 0) Forgotten.Pop().Dispose(); break;
                case "counted": Count(); break;
                case "quit": EditorApplication.SayQuitting(); break;
                default: throw new ArgumentException(what);
            }
        }

        private static void Draw(string pressed, int times = 1)
        {
            Drawing.Lines.Clear();
            Drawing.Pressed = pressed;
            player?.Frame();
            EditorApplication.update?.Invoke();
            drawn?.Draw();
            if (player != null) Console.WriteLine($"hud: {shown.text}");
            foreach (var window in EditorWindow.Opened)
            {
                window.GetType().GetMethod("OnInspectorUpdate", Any)?.Invoke(window, null);
                for (var i = 0; i < times; i++) window.GetType().GetMethod("OnGUI", Any)?.Invoke(window, null);
            }
            foreach (var line in Drawing.Lines) Console.WriteLine(line);
        }

        private static void Call<T>(Func<T, bool> which) where T : Attribute
        {
            foreach (var method in Package.GetTypes().SelectMany(type => type.GetMethods(Any)))
                if (method.GetCustomAttributes<T>().Any(which))
                    method.Invoke(null, method.GetParameters().Select(_ => (object)new MenuCommand(null)).ToArray());
            foreach (var line in Drawing.Lines) Console.WriteLine(line);
            Drawing.Lines.Clear();
        }

        private static void Play(string[] words)
        {
            var lessons = typeof(NetMQLifetime).Assembly;
            var types = Scripts.Of(lessons, words[0]);
            player = new Player(lessons);
            EditorApplication.Say(PlayModeStateChange.ExitingEditMode);
            EditorApplication.isPlaying = true;
            player.Begin(() =>
            {
                var thing = new GameObject("client");
                thing.SetActive(false);
                var scripts = Scripts.AddTo(thing, types);
                Inspector.Set(scripts, "endpoint", words[1]);
                Inspector.Set(scripts, "count", words[2]);
                if (words.Length > 3) Inspector.Set(scripts, "timeout", words[3]);
                inspector = ScriptableObject.CreateInstance<ClientInspector>();
                inspector.targets = new Object[] { scripts.OfType<ConnectedBehaviour>().First() };
                drawn = inspector.CreateInspectorGUI();
                var hud = new GameObject("hud");
                hud.AddComponent<TextMesh>();
                typeof(ClientHud).GetField("client", Any).SetValue(hud.AddComponent<ClientHud>(), inspector.target);
                shown = hud.GetComponent<TextMesh>();
                thing.SetActive(true);
            });
        }

        private static void Another(string endpoint)
        {
            var thing = new GameObject("another");
            thing.SetActive(false);
            var script = (MonoBehaviour)thing.AddComponent(inspector.target.GetType());
            Inspector.Set(new[] { script }, "endpoint", endpoint);
            thing.SetActive(true);
            inspector.targets = new[] { inspector.target, script };
        }

        private static void Stop()
        {
            player.Stop();
            (player, inspector, drawn, EditorApplication.isPlaying) = (null, null, null, false);
            EditorApplication.Say(PlayModeStateChange.EnteredEditMode);
        }

        private static void SetHost(string host) =>
            typeof(ServerAddress).GetField("host", Any)
                .SetValue(Resources.Load<ServerAddress>(ServerAddress.File), host);

        private static void Build(string[] words)
        {
            var target = (BuildTarget)Enum.Parse(typeof(BuildTarget), words[0]);
            var (guards, report) = (new BuildGuards(), new BuildReport(target));
            PlayerSettings.Android.targetSdkVersion = (AndroidSdkVersions)int.Parse(words.ElementAtOrDefault(2) ?? "0");
            guards.OnPreprocessBuild(report);
            var thing = new GameObject("client");
            thing.SetActive(false);
            thing.AddComponent<HelloClient>();
            guards.OnProcessScene(default, report);
            Object.DestroyImmediate(thing);
            BuildGuards.AddNetworkSentence(target, words[1]);
            foreach (var line in Drawing.Lines) Console.WriteLine(line);
            Drawing.Lines.Clear();
            Console.WriteLine($"link: {guards.GenerateAdditionalLinkXmlFile(report, null)}");
        }

        private static void Count()
        {
            var (seen, made) = (0, 0);
            NetMQConnection.Seen += (endpoint, sent, frames) => seen++;
            using var connection = new NetMQConnection("tcp://127.0.0.1:9", () => new DealerSocket());
            connection.Show(true, new[] { $"{++made}" });
            Console.WriteLine($"seen {seen}, made {made}");
            connection.TrySend(TimeSpan.FromSeconds(1), default, "compiled for the editor");
            Console.WriteLine($"seen {seen}");
        }
    }
}
