// Application 21, what a character has said so far: of a newer text only the end is new, however many were lost in
// between.
//
// The Python side is python/21_talking_character/server.py.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Text.RegularExpressions;
using System.Threading;

namespace NetMQExample
{
    /// <summary>Of one speech. Use it on one thread.</summary>
    public sealed class Speech
    {
        private string shown = "", unfinished = "";
        private JobNews newest;

        /// <summary>All of it, in one line.</summary>
        public string Text { get; private set; } = "";

        public int Words { get; private set; }

        /// <summary>The payload of a job in which the character speaks.</summary>
        /// <param name="prompt">The question, in at most 1000 characters.</param>
        /// <exception cref="ArgumentException">The prompt is empty or too long.</exception>
        public static Message Ask(JobClient client, string prompt, int most) =>
            prompt.Length > 0 && prompt.Length <= 1000
                ? client.Goal("talk", most, prompt)
                : throw new ArgumentException("prompt takes 1 to 1000 characters");

        /// <summary>For Watch: who stops listening walks away, too, and there is a moment for the server to hear of
        /// it.</summary>
        public static CancellationToken LeaveAt(JobClient client, CancellationToken stop)
        {
            var moment = new CancellationTokenSource();
            stop.Register(() =>
            {
                client.Cancel();
                // Stop in Unity waits for 200 ms at most.
                moment.CancelAfter(150);
            });
            return moment.Token;
        }

        /// <summary>Takes the newest state.</summary>
        /// <returns>The text behind what was written so far: a line for each sentence.</returns>
        public string Hear(JobNews news)
        {
            newest = news;
            // At another end the text says why there is no more.
            if (news.Kind == "feedback" || news.Status == "succeeded")
            {
                var words = news.Text.Split((char[])null, StringSplitOptions.RemoveEmptyEntries);
                Words = words.Length;
                Text = LogText.Printable(string.Join(" ", words), int.MaxValue);
            }
            var lines = Text == "" ? "" : Regex.Replace($"she: {Text}", "(?<=[.!?]) ", "\nshe: ");
            if (news.Kind == "result" && lines != "") lines += "\n";
            var end = lines.Substring(Math.Min(shown.Length, lines.Length));
            shown = lines;
            return end;
        }

        /// <summary>The same for a log.</summary>
        /// <returns>The sentences that are complete now.</returns>
        public IReadOnlyList<string> Sentences(JobNews news)
        {
            var lines = (unfinished + Hear(news)).Split('\n');
            unfinished = lines[lines.Length - 1];
            return lines.Take(lines.Length - 1).Select(line => line.Substring("she: ".Length)).ToList();
        }

        /// <summary>The line after the result.</summary>
        /// <exception cref="GaveUpException">It was aborted.</exception>
        public string Outcome() => newest.Status switch
        {
            "aborted" => throw new GaveUpException(
                $"the answer broke off: {LogText.Printable(newest.Text)}; ask again"),
            "canceled" => $"done: {Words} words, and you walked away",
            _ => $"done: {Words} words",
        };
    }
}
