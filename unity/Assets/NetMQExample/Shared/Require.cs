// Rules that many classes share for what they are given; what breaks one is named in one line. In Python: check.py.
using System;
using System.Text;

namespace NetMQExample
{
    /// <summary>Public, so that a copy of a kit's file in a project of yours finds it.</summary>
    public static class Require
    {
        private static readonly TimeSpan Day = TimeSpan.FromDays(1);

        /// <summary>A time to wait: more than 0 s, and at most a day.</summary>
        public static TimeSpan Seconds(string name, TimeSpan value) => value > TimeSpan.Zero && value <= Day
            ? value
            : throw new ArgumentException(FormattableString.Invariant(
                $"{name} must be more than 0 s and at most a day, not {value.TotalSeconds}"));

        /// <summary>A value that cannot be left out.</summary>
        public static T Given<T>(string name, T value) where T : class => value
            // As the message alone: with the name as a parameter, Mono writes two lines.
            ?? throw new ArgumentNullException(null, $"{name} must not be null");

        /// <summary>A text for one frame. A server hangs up on a longer one, without a word.</summary>
        public static string Text(string name, string value) => Encoding.UTF8.GetByteCount(Given(name, value)) <= 65536
            ? value
            : throw new ArgumentException($"{name} has more than 65536 bytes: lesson 05 carries more");

        /// <summary>How many there are, or may be.</summary>
        public static int Count(string name, int value, int least = 1) => value >= least
            ? value
            : throw new ArgumentException($"{name} must be {least} or more, not {value}");
    }
}
