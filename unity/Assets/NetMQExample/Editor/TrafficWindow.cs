// Tools > NetMQ Example > Traffic: what the clients in this editor send and receive, while the window is open.
using System;
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
}
