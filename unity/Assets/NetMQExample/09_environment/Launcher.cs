// Lesson 09, who launched this program: when that ends, in whatever way, so does this. In Python: launch.py.
//
// A training that is killed can end nobody. So it gives to each simulator that it launches a pipe, as its standard
// input, in which nothing ever comes but one byte at the beginning; and the system closes it when the training ends.
using System;
using System.Diagnostics;
using System.IO;
using System.Threading;

namespace NetMQExample
{
    /// <summary>Watches the program that has launched this one.</summary>
    public static class Launcher
    {
        /// <summary>Set for a program that was launched: the process id of the one that did it.</summary>
        public const string Variable = "NETMQ_EXAMPLE_LAUNCHER";

        private static int watched;

        /// <summary>From now on this process ends with the one that launched it; without one, nothing happens. Once is
        /// enough.</summary>
        public static void Watch()
        {
            if (!int.TryParse(Environment.GetEnvironmentVariable(Variable), out var launcher)) return;
            if (Interlocked.Exchange(ref watched, 1) == 1) return;
            new Thread(() => Wait(launcher)) { IsBackground = true, Name = nameof(Launcher) }.Start();
        }

        private static void Wait(int launcher)
        {
            try
            {
                using var pipe = Console.OpenStandardInput();
                // Without the byte it is no pipe of a training's: some games have no standard input.
                if (pipe.ReadByte() < 0)
                    while (IsRunning(launcher)) Thread.Sleep(500);
                while (pipe.ReadByte() >= 0) { }
            }
            catch (IOException) { /* The pipe is closed, too. */ }
            // Not Application.Quit: a game that hangs would stay.
            Process.GetCurrentProcess().Kill();
        }

        private static bool IsRunning(int id)
        {
            try
            {
                using var process = Process.GetProcessById(id);
                return !process.HasExited;
            }
            catch (Exception e) when (e is ArgumentException || e is InvalidOperationException) { return false; }
        }
    }
}
