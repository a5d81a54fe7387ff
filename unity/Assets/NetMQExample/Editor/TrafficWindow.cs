// Tools > NetMQ Example > Traffic: what the clients in this editor send and receive, while the window is open.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using System.Text;
using NetMQ;
using UnityEditor;
using UnityEngine;

namespace NetMQExample.Editor
{
    /// <summary>The window of messages.</summary>
    internal sealed class TrafficWindow : EditorWindow
    {
        // A text field takes no more than some 16,000 characters; the clipboard gets all.
        private const int ShownLines = 60, LongestCharacters = 15_000;

        [SerializeField] private string filter = "";
        [SerializeField] private Vector2 scrolled;

        private readonly TrafficLog log = new TrafficLog();
        private string text = "";

        [MenuItem("Tools/NetMQ Example/Traffic", false, 1)]
        public static void Open() => GetWindow<TrafficWindow>("NetMQ traffic");

        private void OnEnable() => log.Begin();
        private void OnDisable() => log.End();

        // Ten times a second, and not while it is drawn: between layout and drawing nothing may change.
        private void OnInspectorUpdate()
        {
            var before = text;
            text = log.Text(filter, ShownLines);
            text = text.Substring(Math.Max(0, text.Length - LongestCharacters));
            // To the end: the newest line is the one to read.
            if (text != before) scrolled.y = float.MaxValue;
            Repaint();
        }

        private void OnGUI()
        {
            filter = EditorGUILayout.TextField("Only lines with", filter);
            if (GUILayout.Button(log.Paused ? "Go on" : "Pause")) log.Paused = !log.Paused;
            if (GUILayout.Button("Copy")) EditorGUIUtility.systemCopyBuffer = log.Text(filter);
            scrolled = EditorGUILayout.BeginScrollView(scrolled);
            EditorGUILayout.TextArea(text, GUILayout.ExpandHeight(true));
            EditorGUILayout.EndScrollView();
        }
    }

    /// <summary>The messages that were sent and received since <see cref="Begin"/>.</summary>
    internal sealed class TrafficLog
    {
        private const int MostLines = 1000;
        private static readonly Encoding Strict = new UTF8Encoding(false, true);

        private readonly Queue<string> lines = new Queue<string>();

        public bool Paused { get; set; }

        public void Begin() => NetMQConnection.Seen += Add;
        public void End() => NetMQConnection.Seen -= Add;

        /// <summary>The newest lines that have this text in them, in upper or lower case.</summary>
        public string Text(string filter, int most = MostLines)
        {
            lock (lines)
            {
                var found = lines.Where(line => line.IndexOf(filter, StringComparison.OrdinalIgnoreCase) >= 0).ToList();
                return string.Join("\n", found.Skip(found.Count - most));
            }
        }

        private void Add(string endpoint, bool sent, IEnumerable frames)
        {
            if (Paused) return;
            var time = DateTime.Now.ToString("HH:mm:ss.fff", CultureInfo.InvariantCulture);
            // At once: the bytes are lent.
            var message = string.Join(" | ", frames.Cast<object>().Select(Shown));
            var line = $"{time} {endpoint} {(sent ? '>' : '<')} {message}";
            lock (lines)
            {
                lines.Enqueue(line);
                if (lines.Count > MostLines) lines.Dequeue();
            }
        }

        private static string Shown(object frame) => frame switch
        {
            NetMQFrame whole => Shown(new ReadOnlyMemory<byte>(whole.Buffer, 0, whole.MessageSize)),
            byte[] bytes => Shown(new ReadOnlyMemory<byte>(bytes)),
            ReadOnlyMemory<byte> bytes => Shown(bytes),
            _ => LogText.Printable($"{frame}"),
        };

        // Of a picture nobody wants to read the bytes.
        private static string Shown(ReadOnlyMemory<byte> bytes)
        {
            try
            {
                if (bytes.Length <= 10_000) return LogText.Printable(Strict.GetString(bytes.ToArray()));
            }
            catch (ArgumentException) { /* It is no UTF-8. */ }
            return $"({bytes.Length} bytes)";
        }
    }
}
