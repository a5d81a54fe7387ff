// What a Play has left behind: clients that a script has made and not disposed.
using System;
using System.Diagnostics;
using UnityEditor;
using Debug = UnityEngine.Debug;

namespace NetMQExample.Editor
{
    /// <summary>Says once after a Play how many there are.</summary>
    internal static class ForgottenClients
    {
        // What Stop has not waited for, such as a slow look-up of a host name, has ended by then, or nearly always.
        private static readonly TimeSpan Patience = TimeSpan.FromSeconds(2);
        private static Stopwatch sinceStop;

        [InitializeOnLoadMethod]
        private static void Load() => EditorApplication.playModeStateChanged += Change;

        private static void Change(PlayModeStateChange state)
        {
            EditorApplication.update -= Look;
            if (state != PlayModeStateChange.EnteredEditMode) return;
            sinceStop = Stopwatch.StartNew();
            EditorApplication.update += Look;
        }

        private static void Look()
        {
            var left = NetMQLifetime.Users;
            if (left > 0 && sinceStop.Elapsed < Patience) return;
            EditorApplication.update -= Look;
            if (left == 0) return;
            Debug.LogWarning($"NetMQ clients that were not disposed: {left}; call Dispose in OnDisable or OnDestroy of "
                + "the script that made them, or the next Play waits 10 s for them");
        }
    }
}
