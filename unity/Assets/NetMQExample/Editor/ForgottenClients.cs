// Warns of clients that a script has made and not disposed when a Play ends.
using System;
using System.Diagnostics;
using UnityEditor;
using Debug = UnityEngine.Debug;

namespace NetMQExample.Editor
{
    /// <summary>Says once after a Play how many there are.</summary>
    internal static class ForgottenClients
    {
        // A slow look-up of a host name, for which Stop does not wait, has nearly always ended by then.
        private static readonly TimeSpan Timeout = TimeSpan.FromSeconds(2);
        private static Stopwatch sinceStop;
        // Those of the editor itself, such as a window of the user's.
        private static int before;

        [InitializeOnLoadMethod]
        private static void Load() => EditorApplication.playModeStateChanged += Change;

        private static void Change(PlayModeStateChange state)
        {
            EditorApplication.update -= Check;
            if (state == PlayModeStateChange.ExitingEditMode) before = NetMQLifetime.Users;
            if (state != PlayModeStateChange.EnteredEditMode) return;
            sinceStop = Stopwatch.StartNew();
            EditorApplication.update += Check;
        }

        private static void Check()
        {
            var left = NetMQLifetime.Users - before;
            if (left > 0 && sinceStop.Elapsed < Timeout) return;
            EditorApplication.update -= Check;
            if (left <= 0) return;
            Debug.LogWarning($"NetMQ connections that are still open: {left}; call Dispose in OnDisable of the script "
                + "that made them");
        }
    }
}
