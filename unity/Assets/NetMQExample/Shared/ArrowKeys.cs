// The keys that lessons 08 to 11 are played with, by whichever of Unity's two input systems the project has: the Input
// Manager, or the package Input System, which is all that a new project of Unity 6 listens to.
using UnityEngine;
#if NETMQEXAMPLE_INPUT_SYSTEM && !ENABLE_LEGACY_INPUT_MANAGER
using UnityEngine.InputSystem;
#endif

namespace NetMQExample
{
    /// <summary>Arrows or W, A, S, D, the space bar and Enter. For Update.</summary>
    public static class ArrowKeys
    {
        /// <summary>From -1, left, to 1, right.</summary>
        public static float Horizontal => Axis("Horizontal");

        /// <summary>From -1, down, to 1, up.</summary>
        public static float Vertical => Axis("Vertical");

        public static bool Space => IsDown(KeyCode.Space);
        public static bool Enter => IsDown(KeyCode.Return);

#if ENABLE_LEGACY_INPUT_MANAGER
        private static float Axis(string name) => Input.GetAxis(name);
        private static bool IsDown(KeyCode key) => Input.GetKey(key);
#elif NETMQEXAMPLE_INPUT_SYSTEM
        private static float Axis(string name) => name == "Vertical"
            ? Either(Key.UpArrow, Key.W) - Either(Key.DownArrow, Key.S)
            : Either(Key.RightArrow, Key.D) - Either(Key.LeftArrow, Key.A);

        private static int Either(Key one, Key other) => IsDown(one) || IsDown(other) ? 1 : 0;
        private static bool IsDown(KeyCode key) => IsDown(key == KeyCode.Space ? Key.Space : Key.Enter);

        // A headset has no keyboard.
        private static bool IsDown(Key key) => Keyboard.current != null && Keyboard.current[key].isPressed;
#else
        static ArrowKeys() => Debug.LogWarning("no keyboard: install the package Input System, or set Project "
            + "Settings, Player, Active Input Handling to Both");

        private static float Axis(string name) => 0;
        private static bool IsDown(KeyCode key) => false;
#endif
    }
}
