// Lesson 14, what a message about a job says: read and put into words on the network thread, ready to be shown.
//
// In Python it is 14_long_jobs/progress.py; netmq_example/jobs/client.py reads it.
using System;
using System.Collections.Generic;
using System.Linq;

namespace NetMQExample
{
    /// <summary>The newest about a job. It never changes, so every thread may have it.</summary>
    public sealed class JobNews
    {
        private const int LargestSidePixels = 4096;

        private static readonly string[] Kinds = { "accepted", "feedback", "canceling", "result", "forgotten" };
        private static readonly string[] Statuses = { "succeeded", "canceled", "aborted" };

        /// <summary>Reads a message.</summary>
        /// <exception cref="MessageException">Something is missing in it.</exception>
        public JobNews(Message message)
        {
            Kind = Require.Given("message", message).Kind;
            Job = Take<string>(message, "job");
            Status = "";
            if (Array.IndexOf(Kinds, Kind) < 0) throw Wrong("unknown-kind", "kind", Kind, Kinds);
            if (Kind != "forgotten") Seq = Count(message, "seq");
            if (Kind == "accepted") Position = Count(message, "position");
            else if (Kind != "forgotten")
            {
                Done = Count(message, "done");
                Total = Count(message, "total");
                Text = Take<string>(message, "text");
            }
            if (Kind == "result") Status = Take<string>(message, "status");
            if (Kind == "result" && Array.IndexOf(Statuses, Status) < 0)
                throw Wrong("bad-status", "status", Status, Statuses);
            var finished = message.Arrays.FirstOrDefault();
            Finished = finished?.Data ?? default;
            if (finished?.Dtype == "uint8" && finished.Shape is { Length: 3 } shape && shape[2] == 3
                && shape[0] <= shape[1] && shape[1] > 0 && shape[1] <= LargestSidePixels)
            {
                Side = shape[1];
                Pixels = Upwards(shape[0], shape[1]);
            }
            var name = $"job {Job.Substring(0, Math.Min(Job.Length, 8))}";
            Line = LogText.Printable($"{name}: {Words}");
        }

        /// <summary>The verb: accepted, feedback, canceling, result or forgotten.</summary>
        public string Kind { get; }

        public string Job { get; }

        /// <summary>Of a result: succeeded, canceled or aborted.</summary>
        public string Status { get; }

        /// <summary>Grows with each message about a job.</summary>
        public long Seq { get; }

        public long Done { get; }
        public long Total { get; }

        /// <summary>More about it, in words.</summary>
        public string Text { get; } = "";

        /// <summary>Where it stands in the queue; 0 once it is begun.</summary>
        public long Position { get; }

        /// <summary>What is finished so far.</summary>
        public ReadOnlyMemory<byte> Finished { get; }

        /// <summary>The width and height of the picture, if it is one.</summary>
        public int Side { get; }

        /// <summary>The picture so far, as Unity's textures have it: RGB, the lowest row first.</summary>
        public byte[] Pixels { get; }

        public string Line { get; }

        /// <summary>How much is done, from 0 to 1.</summary>
        public float Share => Math.Clamp((float)((double)Done / Math.Max(Total, 1)), 0, 1);

        /// <summary>The line for the end.</summary>
        public string Outcome
        {
            get
            {
                long sum = 0;
                // An array: the compiler turns a loop over a span into its indexer, which Mono does not have.
                foreach (var one in Finished.ToArray()) sum += one;
                return $"done: {LogText.Printable(Status)}, {Finished.Length} bytes, sum {sum}";
            }
        }

        private string Words
        {
            get
            {
                if (Kind == "accepted")
                    return Position > 0 ? $"accepted, number {Position} of those that wait" : "accepted";
                if (Kind != "feedback" && Kind != "result") return Kind;
                var place = Kind == "result" ? $"{Status} at {Done} of {Total}" : $"{Done} of {Total}";
                return Text == "" ? place : $"{place}, {Text}";
            }
        }

        /// <summary>Whether it is in the same tenth of the job as the message before: one line for each is
        /// enough.</summary>
        public bool SameTenthAs(JobNews before) => Kind == "feedback" && before?.Kind == "feedback"
            && Done * 10 / Math.Max(Total, 1) == before.Done * 10 / Math.Max(before.Total, 1);

        // Its rows come from the top; those that are not there yet are black.
        private byte[] Upwards(int rows, int side)
        {
            var pixels = new byte[side * side * 3];
            for (var row = 0; row < rows; row++)
                Finished.Span.Slice(row * side * 3, side * 3)
                    .CopyTo(new Span<byte>(pixels, (side - 1 - row) * side * 3, side * 3));
            return pixels;
        }

        // In the words of the Python side.
        internal static T Take<T>(Message message, string name)
        {
            if (!message.Values.TryGetValue(name, out var found))
                throw new MessageException("missing-field", $"there is no '{name}'");
            return found is T value ? value : throw new MessageException(
                "wrong-type", $"'{name}' must be {(typeof(T) == typeof(string) ? "str" : "int")}");
        }

        private static long Count(Message message, string name)
        {
            var count = Take<long>(message, name);
            return count >= 0 ? count : throw new MessageException("bad-value", $"'{name}' must be 0 or more");
        }

        private static MessageException Wrong(string code, string what, string found, string[] known) =>
            new MessageException(code, $"{what} '{Cut(found)}' is none of {string.Join(", ", known)}");

        private static string Cut(string text) => LogText.Printable(text.Substring(0, Math.Min(text.Length, 38)));
    }
}
