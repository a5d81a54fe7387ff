// Keys, as a test presses them: the player has no window.
using System.Collections.Generic;

namespace UnityEngine
{
    public enum KeyCode
    {
        Return = 13,
        Space = 32,
    }

    public class Input
    {
        internal static HashSet<KeyCode> Pressed { get; } = new HashSet<KeyCode>();

        // Those that were not pressed in the frame before.
        internal static HashSet<KeyCode> Down { get; } = new HashSet<KeyCode>();

        internal static float Horizontal { get; set; }

        internal static float Vertical { get; set; }

        public static float GetAxis(string axisName)
        {
            MainThread.Only(nameof(GetAxis));
            return axisName == "Horizontal" ? Horizontal : axisName == "Vertical" ? Vertical
                : throw new System.ArgumentException($"Input Axis {axisName} is not setup.");
        }

        public static bool GetKey(KeyCode key)
        {
            MainThread.Only(nameof(GetKey));
            return Pressed.Contains(key);
        }

        public static bool GetKeyDown(KeyCode key)
        {
            MainThread.Only(nameof(GetKeyDown));
            return Down.Contains(key);
        }
    }
}
