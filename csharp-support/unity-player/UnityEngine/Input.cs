// Keys, as a test presses them: the player has no window, and a mouse that lies still.
using System;
using System.Collections.Generic;

namespace UnityEngine
{
    public enum KeyCode
    {
        None = 0, Backspace = 8, Tab = 9, Return = 13, Escape = 27, Space = 32, Delete = 127,
        Alpha0 = 48, Alpha1, Alpha2, Alpha3, Alpha4, Alpha5, Alpha6, Alpha7, Alpha8, Alpha9,
        A = 97, B, C, D, E, F, G, H, I, J, K, L, M, N, O, P, Q, R, S, T, U, V, W, X, Y, Z,
        KeypadEnter = 271, UpArrow = 273, DownArrow, RightArrow, LeftArrow,
        F1 = 282, F2, F3, F4, F5, F6, F7, F8, F9, F10, F11, F12,
        RightShift = 303, LeftShift, RightControl, LeftControl, RightAlt, LeftAlt, Mouse0 = 323, Mouse1, Mouse2,
    }

    public enum CursorLockMode { None, Locked, Confined }

    public class Cursor
    {
        public static bool visible { get; set; } = true;
        public static CursorLockMode lockState { get; set; }
    }

    public class Input
    {
        internal static HashSet<KeyCode> Pressed { get; } = new HashSet<KeyCode>();
        // Those that were not pressed in the frame before, and those that no longer are.
        internal static HashSet<KeyCode> Down { get; } = new HashSet<KeyCode>();
        internal static HashSet<KeyCode> Up { get; } = new HashSet<KeyCode>();
        internal static float Horizontal { get; set; }
        internal static float Vertical { get; set; }
        public static float GetAxisRaw(string axisName) => GetAxis(axisName);
        public static float GetAxis(string axisName)
        {
            MainThread.Only(nameof(GetAxis));
            return axisName switch
            {
                "Horizontal" => Horizontal,
                "Vertical" => Vertical,
                "Mouse X" => 0,
                "Mouse Y" => 0,
                "Mouse ScrollWheel" => 0,
                _ => throw new ArgumentException($"Input Axis {axisName} is not setup."),
            };
        }

        public static bool GetKey(KeyCode key) => Has(Pressed, key);
        public static bool GetKeyDown(KeyCode key) => Has(Down, key);
        public static bool GetKeyUp(KeyCode key) => Has(Up, key);
        public static bool GetButton(string buttonName) => Has(Pressed, Of(buttonName));
        public static bool GetButtonDown(string buttonName) => Has(Down, Of(buttonName));
        public static bool GetButtonUp(string buttonName) => Has(Up, Of(buttonName));
        public static bool GetMouseButton(int button) => Has(Pressed, KeyCode.Mouse0 + button);
        public static bool GetMouseButtonDown(int button) => Has(Down, KeyCode.Mouse0 + button);
        public static bool GetMouseButtonUp(int button) => Has(Up, KeyCode.Mouse0 + button);
        public static bool anyKey => Pressed.Count > 0;
        public static bool anyKeyDown => Down.Count > 0;
        public static Vector3 mousePosition => default;

        // As a new project has them.
        private static KeyCode Of(string button) => button switch
        {
            "Jump" => KeyCode.Space,
            "Fire1" => KeyCode.LeftControl,
            "Fire2" => KeyCode.LeftAlt,
            "Fire3" => KeyCode.LeftShift,
            "Submit" => KeyCode.Return,
            "Cancel" => KeyCode.Escape,
            _ => throw new ArgumentException($"Input Button {button} is not setup."),
        };

        private static bool Has(HashSet<KeyCode> keys, KeyCode key)
        {
            MainThread.Only(nameof(GetKey));
            return keys.Contains(key);
        }
    }
}
