// A progress bar for lesson 14: on a terminal a bar that grows, and elsewhere a line at each tenth.
using System;
using System.Globalization;

namespace NetMQExample.Terminal
{
    /// <summary>Shows one message about a job after the other.</summary>
    internal sealed class ProgressBar
    {
        private const int Width = 30;
        private const string Erase = "\x1b[K";
        private JobNews? before;

        public void Show(JobNews news)
        {
            if (Console.IsOutputRedirected)
            {
                if (!news.SameTenthAs(before)) Console.WriteLine(news.Line);
            }
            else if (news.Kind == "feedback")
            {
                var bar = new string('#', (int)(news.Share * Width)).PadRight(Width);
                Console.Write($"\r[{bar}] {news.Line}{Erase}");
            }
            else Say(news.Line);
            before = news;
        }

        /// <summary>A line of its own, over the bar.</summary>
        public void Say(string line) => Console.WriteLine(Console.IsOutputRedirected ? line : $"\r{line}{Erase}");
    }
}
