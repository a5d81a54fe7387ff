// The arrow keys, or W, A, S, D, as a steering wheel, for lesson 08. A terminal tells when a key is pressed, and not
// when it is let go: what was set stays set.
using System;
using System.Runtime.InteropServices;

namespace NetMQExample.Terminal
{
    /// <summary>An arrow key, its letter or the space bar takes over, Enter gives back.</summary>
    internal sealed class Keyboard
    {
        // .NET has the terminal echo again after a signal that somebody listens for. Without this, SIGTERM is none.
        private readonly PosixSignalRegistration atEnd =
            PosixSignalRegistration.Create(PosixSignal.SIGTERM, signal => { });
        private double throttle, brake, steer;

        public Keyboard()
        {
            if (Console.IsInputRedirected) throw new UsageException("--drive needs a keyboard: start it in a terminal");
        }

        /// <summary>Takes what was pressed since the last call.</summary>
        public void Poll(Drive drive)
        {
            while (Console.KeyAvailable)
            {
                var key = Console.ReadKey(true).Key;
                if (key == ConsoleKey.LeftArrow || key == ConsoleKey.A) steer = Math.Max(-1, steer - 0.1);
                else if (key == ConsoleKey.RightArrow || key == ConsoleKey.D) steer = Math.Min(1, steer + 0.1);
                else if (key == ConsoleKey.UpArrow || key == ConsoleKey.W) Throttle(0.2);
                else if (key == ConsoleKey.DownArrow || key == ConsoleKey.S) Throttle(-0.2);
                else if (key == ConsoleKey.Spacebar) (throttle, brake) = (0, 1);
                else if (key != ConsoleKey.Enter) continue;
                if (key == ConsoleKey.Enter) drive.GiveBack();
                else drive.TakeOver(throttle, brake, steer);
            }
        }

        // Rounded, so that it comes back to 0 on its way from forwards to backwards.
        private void Throttle(double change) =>
            (throttle, brake) = (Math.Clamp(Math.Round(throttle + change, 1), -1, 1), 0);
    }
}
