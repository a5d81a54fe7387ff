// Lesson 10, infos: what a game says to Python, or of an agent, between two answers. In Python: simulation.py.
using System.Collections.Generic;

namespace NetMQExample
{
    /// <summary>The infos between two answers: no more than fit, and the others are counted.</summary>
    public sealed class InfoQueue
    {
        private const int LimitBytes = 12_000;

        private List<object> infos = new List<object>();
        private int size;
        private long dropped;

        /// <summary>Python gets it with the next answer.</summary>
        /// <param name="agent">The agent; empty: the environment.</param>
        /// <param name="info">Texts, numbers, true, false, arrays, lists and dictionaries by name.</param>
        /// <exception cref="MessageException">There is something else in it.</exception>
        public void Send(string agent, IReadOnlyDictionary<string, object> info)
        {
            var one = new List<object> { Require.Given("agent", agent), new Dictionary<string, object>(info) };
            var length = MessageTree.Write(one).Length;
            if (size + length > LimitBytes) dropped++;
            else
            {
                size += length;
                infos.Add(one);
            }
        }

        /// <summary>All of it as a value, or null; and from then on it is empty.</summary>
        public byte[] Take()
        {
            if (dropped > 0)
                infos.Add(new List<object> { "", new Dictionary<string, object> { ["dropped"] = dropped } });
            if (infos.Count == 0) return null;
            var taken = infos;
            // First: what cannot be written any more is not tried again.
            infos = new List<object>();
            size = 0;
            dropped = 0;
            return MessageTree.Write(taken);
        }
    }
}
