// Lesson 10, the infos: what is said of many, or to them, in one value of a message. In Python: infos.py.
//
//     [["hunter_0",{"energy":0.5}],["",{"weather":"rain"}]]        JSON; "" is the environment
//
// An info is flat: texts, numbers, true and false by name, as the values of a message are.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Runtime.InteropServices;
using System.Text;

namespace NetMQExample
{
    /// <summary>Infos as one text.</summary>
    public static class Infos
    {
        /// <summary>Who is meant, a name or a number, and the info.</summary>
        /// <exception cref="MessageException">Something in it is no text, no finite number, not true or
        /// false.</exception>
        public static string Pack(IEnumerable<(object Who, IReadOnlyDictionary<string, object> Info)> infos) =>
            MessageJson.Write(infos.Select(one => new object[]
            {
                one.Who,
                one.Info.ToDictionary(value => value.Key, value => Message.Checked(value.Key, value.Value)),
            }));

        /// <summary>The infos in a text that somebody sent, each for an agent.</summary>
        /// <exception cref="MessageException">They are none.</exception>
        public static IEnumerable<(string Whom, IReadOnlyDictionary<string, object> Info)> Unpack(object text)
        {
            var json = text as string ?? throw Bad("it is no text");
            var list = MessageJson.Read(Encoding.UTF8.GetBytes(json)) as List<object> ?? throw Bad("it is no list");
            foreach (var one in list)
            {
                if (!(one is List<object> pair && pair.Count == 2 && pair[0] is string agent
                    && pair[1] is Dictionary<string, object> info)) throw Bad("one is not a name and an info");
                foreach (var value in info) Message.Checked(value.Key, value.Value);
                yield return (agent, info);
            }
        }

        /// <summary>The arrays rewards float64 [n], terminated and truncated uint8 [n].</summary>
        /// <exception cref="MessageException">A reward is no finite number.</exception>
        internal static IEnumerable<MessageArray> Judged((double Reward, bool Terminated, bool Truncated)[] judged)
        {
            var rewards = Array.ConvertAll(judged, one => one.Reward);
            if (rewards.Any(reward => double.IsNaN(reward) || double.IsInfinity(reward)))
                throw new MessageException("bad-reward", "a reward is no finite number");
            MessageArray Flags(IEnumerable<bool> flags) =>
                new MessageArray("uint8", flags.Select(flag => (byte)(flag ? 1 : 0)).ToArray(), judged.Length);
            yield return new MessageArray(
                "float64", MemoryMarshal.AsBytes<double>(rewards).ToArray(), rewards.Length);
            yield return Flags(judged.Select(one => one.Terminated));
            yield return Flags(judged.Select(one => one.Truncated));
        }

        private static MessageException Bad(string why) => new MessageException("bad-infos", why);
    }

    /// <summary>What is said between two messages: no more than fits into one, and what was left out is
    /// counted.</summary>
    public sealed class InfoQueue
    {
        // Characters. In a header each may take four bytes, and a header has at most 64 KB.
        private const int LimitCharacters = 12_000;

        private readonly List<(object, IReadOnlyDictionary<string, object>)> infos =
            new List<(object, IReadOnlyDictionary<string, object>)>();
        private int size;
        private long dropped;

        /// <summary>Python gets it with the next answer.</summary>
        /// <param name="agent">Whose it is; empty: the environment's.</param>
        /// <param name="info">Texts, numbers, true and false by name.</param>
        /// <exception cref="MessageException">There is something else in it.</exception>
        public void Send(string agent, IReadOnlyDictionary<string, object> info)
        {
            var one = ((object)agent, (IReadOnlyDictionary<string, object>)new Dictionary<string, object>(info));
            var length = Infos.Pack(new[] { one }).Length;
            if (size + length > LimitCharacters) dropped++;
            else
            {
                size += length;
                infos.Add(one);
            }
        }

        /// <summary>All of it, and from then on it is empty.</summary>
        public string Take()
        {
            if (dropped > 0) infos.Add(("", new Dictionary<string, object> { ["dropped"] = dropped }));
            var text = Infos.Pack(infos);
            infos.Clear();
            size = 0;
            dropped = 0;
            return text;
        }
    }
}
