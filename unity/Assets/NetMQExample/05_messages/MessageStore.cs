// The numbers, dictionaries and lists of a message that comes or goes again and again, such as a picture. C# makes an
// object of each number that it puts into a dictionary of objects: a hundred pictures a second would leave a thousand.
using System.Collections.Generic;
using System.Globalization;

namespace NetMQExample
{
    /// <summary>A number in the place of a double, or of a long that is exact as a double.</summary>
    internal sealed class MessageNumber
    {
        public double Real { get; set; }

        public bool IsWhole { get; set; }
        public object Kept => IsWhole ? (long)Real : (object)Real;

        public override string ToString() => string.Format(CultureInfo.InvariantCulture, "{0}", Kept);
    }

    /// <summary>The parts of one message at a time.</summary>
    internal sealed class MessageStore
    {
        private readonly bool keepsNumbers;
        private readonly Shelf<MessageNumber> numbers = new Shelf<MessageNumber>();
        private readonly Shelf<Dictionary<string, object>> objects = new Shelf<Dictionary<string, object>>();
        private readonly Shelf<List<object>> lists = new Shelf<List<object>>();

        /// <param name="keepsNumbers">Whether they are used again as well: each is a MessageNumber then.</param>
        public MessageStore(bool keepsNumbers = false) => this.keepsNumbers = keepsNumbers;

        /// <summary>Takes back all that it gave.</summary>
        public void Clear() => numbers.Used = objects.Used = lists.Used = 0;

        public object Number(long number) => keepsNumbers ? Next(number, true) : (object)number;

        public object Number(double number) => keepsNumbers ? Next(number, false) : (object)number;

        public Dictionary<string, object> Object()
        {
            var next = objects.Next();
            next.Clear();
            return next;
        }

        public List<object> List()
        {
            var next = lists.Next();
            next.Clear();
            return next;
        }

        private MessageNumber Next(double number, bool isWhole)
        {
            var next = numbers.Next();
            next.Real = number;
            next.IsWhole = isWhole;
            return next;
        }

        private sealed class Shelf<T> where T : new()
        {
            private readonly List<T> all = new List<T>();

            public int Used { get; set; }

            public T Next()
            {
                if (Used == all.Count) all.Add(new T());
                return all[Used++];
            }
        }
    }
}
