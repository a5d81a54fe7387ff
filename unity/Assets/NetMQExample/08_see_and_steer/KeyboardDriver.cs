// Lesson 08 in Unity: the arrow keys take over, Enter gives back.
//
// Use: it stands in the lesson's scene beside the car. For a wheel, a gamepad or the Input System of your own call
// Drive.TakeOver in each Update, and Drive.GiveBack.
using System;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>A person at the keyboard: arrows or W, A, S, D, and the space bar to brake.</summary>
    public sealed class KeyboardDriver : MonoBehaviour
    {
#if ENABLE_LEGACY_INPUT_MANAGER
        private void Update()
        {
            var drive = GetComponent<DrivenBehaviour>().Drive;
            var (steer, pedal) = (Input.GetAxis("Horizontal"), Input.GetAxis("Vertical"));
            var brake = Input.GetKey(KeyCode.Space) ? 1 : Math.Max(0, -pedal);
            if (Input.GetKey(KeyCode.Return)) drive.GiveBack();
            // Once taken, it stays in the person's hands, also while no key is pressed.
            else if (drive.Manual || steer != 0 || pedal != 0 || brake > 0)
                drive.TakeOver(Math.Max(0, pedal), brake, steer);
        }
#else
        private void Start() =>
            Debug.Log("no keyboard: set Project Settings, Player, Active Input Handling to Both");
#endif
    }
}
