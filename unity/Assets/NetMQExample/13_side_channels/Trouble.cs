// Lesson 13, trouble: what went wrong, in a line a second at the most.
//
//     SideChannelManager.Report = new Trouble(Debug.LogWarning).Report;
//
// The Python side is trouble.py.
using System;
using Stopwatch = System.Diagnostics.Stopwatch;

namespace NetMQExample.MLAgents.SideChannels
{
    /// <summary>Many messages that are wrong must not fill a disk. For one thread, in Unity the main thread.</summary>
    public sealed class Trouble
    {
        private readonly Action<string> say;
        private readonly Stopwatch said = new Stopwatch();
        private int unsaid;

        public Trouble(Action<string> say) => this.say = Require.Given("say", say);

        public void Report(string line)
        {
            if (said.IsRunning && said.ElapsedMilliseconds < 1000)
            {
                unsaid++;
                return;
            }
            say($"trouble: {LogText.Printable(line)}" + (unsaid > 0 ? $" (and {unsaid} more)" : ""));
            said.Restart();
            unsaid = 0;
        }
    }
}
