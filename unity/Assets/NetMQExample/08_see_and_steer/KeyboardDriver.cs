// Lesson 08 in Unity: the arrow keys or W, A, S, D take over, Enter gives back.
//
// Use: it stands in the lesson's scene beside the car. For a wheel or a gamepad call Drive.TakeOver in each
// Update, and Drive.GiveBack.
using UnityEngine;

namespace NetMQExample
{
    /// <summary>A person at the keyboard: arrows or W, A, S, D, and the space bar to brake. Down brakes while the car
    /// rolls forwards, and then drives backwards.</summary>
    [AddComponentMenu("NetMQ Example/08 Keyboard Driver")]
    public sealed class KeyboardDriver : MonoBehaviour
    {
        // In metres a second: a car with wheels of its own is never quite still.
        private const double StandstillSpeed = 0.1;

        private void Update()
        {
            var car = GetComponent<DrivenBehaviour>();
            var drive = car.Drive;
            var (steer, pedal) = (ArrowKeys.Horizontal, ArrowKeys.Vertical);
            var slows = pedal < 0 && car.Speed > StandstillSpeed;
            var brake = ArrowKeys.Space ? 1 : slows ? -pedal : 0;
            if (ArrowKeys.Enter) drive.GiveBack();
            // Once taken, it stays in the person's hands, also while no key is pressed.
            else if (drive.Manual || steer != 0 || pedal != 0 || brake > 0)
                drive.TakeOver(slows ? 0 : pedal, brake, steer);
        }
    }
}
