// Numbers among the values of a message that is used again. C# makes a new object of each number that goes into a
// dictionary of objects; a hundred pictures a second, each with ten numbers, would leave a thousand of them to collect.
using System.Collections.Generic;
using System.Globalization;

namespace NetMQExample
{
    /// <summary>A number in the place of a long or a double.</summary>
    internal sealed class MessageNumber
    {
        public bool IsWhole { get; set; }

        public long Whole { get; set; }

        public double Real { get; set; }

        /// <summary>The long or the double.</summary>
        public object Kept => IsWhole ? Whole : (object)Real;

        public override string ToString() => string.Format(CultureInfo.InvariantCulture, "{0}", Kept);
    }

    /// <summary>The numbers of one message.</summary>
    internal sealed class MessageNumbers
    {
        private readonly List<MessageNumber> all = new List<MessageNumber>();
        private int used;

        /// <summary>Takes back all that it gave.</summary>
        public void Clear() => used = 0;

        /// <summary>A whole number.</summary>
        public object Put(long number) => Next(true, number, number);

        /// <summary>Any other number.</summary>
        public object Put(double number) => Next(false, 0, number);

        private MessageNumber Next(bool isWhole, long whole, double real)
        {
            if (used == all.Count) all.Add(new MessageNumber());
            var next = all[used++];
            next.IsWhole = isWhole;
            next.Whole = whole;
            next.Real = real;
            return next;
        }
    }
}
