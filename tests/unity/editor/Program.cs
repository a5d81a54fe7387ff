// Does in the editor what a line of the standard input says, and prints what is drawn then.
//
//     api                     what the stand-in of UnityEditor has
//     package PATH            where the package lies; folder PATH: what is chosen when a folder is asked for
//     load                    what Unity does after each reload of the scripts
//     menu ITEM               such as Tools/NetMQ Example/Lessons
//     type LABEL=TEXT         into a field; press BUTTON
//     draw                    the windows, once
//     quit                    the end of the editor
using System;
using System.Linq;
using System.Reflection;
using NetMQExample.Editor;
using NetMQExample.PlayTest;
using UnityEditor;
using Drawing = UnityEditor.Drawing;

namespace NetMQExample.EditorTest
{
    internal static class Program
    {
        private const BindingFlags Any = BindingFlags.Instance | BindingFlags.Static | BindingFlags.Public | BindingFlags.NonPublic;
        private static readonly Assembly Package = typeof(LessonServer).Assembly;

        private static int Main()
        {
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
                case "api": Api.Print(typeof(EditorWindow).Assembly); break;
                case "package": AssetDatabase.Package = with; break;
                case "folder": EditorUtility.Chosen = with; break;
                case "load": Call<InitializeOnLoadMethodAttribute>(_ => true); break;
                case "menu": Call<MenuItem>(item => item.menuItem == with); break;
                case "type": Drawing.Typed[with.Split('=')[0]] = with.Split(new[] { '=' }, 2)[1]; break;
                case "press": Draw(with); break;
                case "draw": Draw(""); break;
                case "clipboard": Console.WriteLine(EditorGUIUtility.systemCopyBuffer); break;
                case "quit": EditorApplication.SayQuitting(); break;
                default: throw new ArgumentException(what);
            }
        }

        private static void Draw(string pressed)
        {
            Drawing.Lines.Clear();
            Drawing.Pressed = pressed;
            foreach (var window in EditorWindow.Open)
            {
                window.GetType().GetMethod("OnInspectorUpdate", Any)?.Invoke(window, null);
                window.GetType().GetMethod("OnGUI", Any)?.Invoke(window, null);
            }
            foreach (var line in Drawing.Lines) Console.WriteLine(line);
        }

        private static void Call<T>(Func<T, bool> which) where T : Attribute
        {
            foreach (var method in Package.GetTypes().SelectMany(type => type.GetMethods(Any)))
                if (method.GetCustomAttributes<T>().Any(which)) method.Invoke(null, null);
        }
    }
}
