// Tells ArrowKeys of each key, where a project listens to the Input System alone, and where it listens to
// nothing that the kit knows. play.csproj compiles it for both.
using System;
using UnityEngine.InputSystem;

namespace NetMQExample.PlayTest
{
    internal static class Keys
    {
        public static int Print()
        {
            Say("no keyboard");
            foreach (Key key in Enum.GetValues(typeof(Key)))
            {
                Keyboard.current = new Keyboard { Pressed = key };
                Say(key);
            }
            for (var i = 0; i < 2; i++)
                Console.WriteLine($"nothing {Nothing.ArrowKeys.Horizontal} {Nothing.ArrowKeys.Vertical} "
                    + $"{Nothing.ArrowKeys.Space} {Nothing.ArrowKeys.Enter}");
            return 0;
        }

        private static void Say(object what) => Console.WriteLine(
            $"{what} {Package.ArrowKeys.Horizontal} {Package.ArrowKeys.Vertical} "
            + $"{Package.ArrowKeys.Space} {Package.ArrowKeys.Enter}");
    }
}

// The script names these of com.unity.inputsystem, as its Keyboard.cs and ButtonControl.cs declare them.
namespace UnityEngine.InputSystem
{
    internal enum Key
    {
        Space = 1, Enter, A = 15, D = 18, S = 33, W = 37, LeftArrow = 61, RightArrow, UpArrow, DownArrow,
    }

    internal sealed class KeyControl
    {
        public bool isPressed { get; set; }
    }

    internal sealed class Keyboard
    {
        public static Keyboard current { get; set; }
        public Key Pressed { get; set; }
        public KeyControl this[Key key] => new KeyControl { isPressed = key == Pressed };
    }
}
