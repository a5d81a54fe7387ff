// Lesson 08 in Unity: the arrow keys take over, Enter gives back.
//
// Use: it stands in the lesson's scene beside the car. For a wheel or a gamepad call Drive.TakeOver in each
// Update, and Drive.GiveBack.
using System;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>A person at the keyboard: arrows or W, A, S, D, and the space bar to brake.</summary>
    [AddComponentMenu("NetMQ Example/08 Keyboard Driver")]
    public sealed class KeyboardDriver : MonoBehaviour
    {
        private void Update()
        {
            var drive = GetComponent<DrivenBehaviour>().Drive;
            var (steer, pedal) = (ArrowKeys.Horizontal, ArrowKeys.Vertical);
            var brake = ArrowKeys.Space ? 1 : Math.Max(0, -pedal);
            if (ArrowKeys.Enter) drive.GiveBack();
            // Once taken, it stays in the person's hands, also while no key is pressed.
            else if (drive.Manual || steer != 0 || pedal != 0 || brake > 0)
                drive.TakeOver(Math.Max(0, pedal), brake, steer);
        }
    }
}
