// When a component may talk: while it is enabled, and on a phone while the game is in front.
using System;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>A component that is connected while it is enabled. How, its own Begin and End say.</summary>
    public abstract class ConnectedBehaviour : MonoBehaviour
    {
        [SerializeField, Tooltip("Go on while another window has the focus; this is a setting of the whole game")]
        private bool runInBackground = true;

        private bool interrupted;

        /// <summary>True once the last line, or the reason why there is none, was logged.</summary>
        public abstract bool Done { get; }

        /// <summary>Why it has given up, with what to do; or an empty text.</summary>
        public string LastError { get; private set; } = "";

        /// <summary>Its state in a few words, for an inspector or a display.</summary>
        public virtual string State =>
            LastError.Length > 0 ? "gave up" : !isActiveAndEnabled ? "disconnected" : Done ? "done" : "connected";

        /// <summary>Connects, and begins from the start.</summary>
        /// <exception cref="ArgumentException">A field is wrong; the message is logged as the reason.</exception>
        protected abstract void Begin();

        /// <summary>Closes the sockets. It may wait for that, as NetworkThread.Join does.</summary>
        protected abstract void End();

        /// <summary>The inspector's seconds as a time.</summary>
        /// <param name="timeout">More than 0, and a day at the most.</param>
        protected static TimeSpan Seconds(float timeout) => timeout > 0 && timeout <= 86400
            ? TimeSpan.FromSeconds(timeout)
            : throw new ArgumentException($"timeout must be more than 0 s and at most a day, not {timeout}");

        /// <summary>Logs why it has ended, and keeps it.</summary>
        protected void GiveUp(string why)
        {
            LastError = why;
            Debug.LogError($"gave up: {why}");
        }

        protected virtual void OnEnable()
        {
            // Enabled while the game is paused, it has begun already.
            LastError = "";
            interrupted = false;
            if (runInBackground && !Application.runInBackground)
            {
                // Without it Unity stops calling Update when another window has the focus.
                Application.runInBackground = true;
                Debug.Log("Application.runInBackground is now true");
            }
            ServerAddress.Apply(this);
            try { Begin(); }
            catch (ArgumentException e)
            {
                GiveUp(e.Message);
                enabled = false;
            }
        }

        /// <summary>Ends, also at Stop and before Unity loads recompiled scripts.</summary>
        protected virtual void OnDisable() => End();

        /// <summary>iOS and Android take the sockets of an app that is not seen: they are closed before, and the lesson
        /// begins again when the app is back.</summary>
        protected virtual void OnApplicationPause(bool paused)
        {
            if (!Application.isMobilePlatform || !isActiveAndEnabled) return;
            if (paused)
            {
                interrupted |= !Done;
                End();
            }
            else if (interrupted)
            {
                interrupted = false;
                Begin();
            }
        }
    }
}
