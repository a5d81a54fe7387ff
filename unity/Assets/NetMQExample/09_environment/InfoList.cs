// Lesson 09, infos: what an agent or the world says to Python between two answers. In Python: scene/agent.py.
using System.Collections.Generic;

namespace NetMQExample
{
    /// <summary>The infos between two answers: no more than fit, and the others are counted.</summary>
    internal sealed class InfoList
    {
        private const int LimitBytes = 12_000;

        private List<object> infos = new List<object>();
        private int size;
        private long dropped;

        public void Send(object info)
        {
            var one = Observed.Of(info);
            var length = MessageTree.Write(one).Length;
            if (size + length > LimitBytes)
            {
                dropped++;
                return;
            }
            size += length;
            infos.Add(one);
        }

        /// <summary>All of it, or null; and from then on it is empty.</summary>
        public List<object> Take()
        {
            if (dropped > 0) infos.Add(new Dictionary<string, object> { ["dropped"] = dropped });
            if (infos.Count == 0) return null;
            var taken = infos;
            infos = new List<object>();
            size = 0;
            dropped = 0;
            return taken;
        }

        /// <summary>Before its own come those of another one.</summary>
        public void InsertFrom(InfoList before)
        {
            infos.InsertRange(0, before.infos);
            size += before.size;
            dropped += before.dropped;
        }

        public void Clear() => Take();
    }
}
