// Lesson 13, the manager: packs what all channels have queued into one exchange, and hands out what has come in one.
//
// An exchange is any number of messages, one after the other; none at all is an exchange, too. It is what ML-Agents
// sends:
//
//     16 bytes    the channel's id, as Guid.ToByteArray gives it
//     4 bytes     how long the message is, int32, little-endian
//     ...         the message, which only its channel understands
//
// The Python side is side_channel_manager.py.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using Stopwatch = System.Diagnostics.Stopwatch;

namespace NetMQExample.MLAgents.SideChannels
{
    /// <summary>The channels of this program. For one thread, in Unity the main thread.</summary>
    public static class SideChannelManager
    {
        // How much is kept for channels that nobody has registered yet: messages, and bytes of each.
        private const int MostKeptMessages = 100, LargestKeptBytes = 65536;

        // A list: they send in the order of their registration.
        private static readonly List<SideChannel> Channels = new List<SideChannel>();
        private static readonly List<(Guid Id, byte[] Data)> Unknown = new List<(Guid, byte[])>();
        // Those of which it was said that what comes for them is dropped.
        private static readonly HashSet<Guid> Dropped = new HashSet<Guid>();

        /// <summary>Gets a line about what could not be delivered, or not yet.</summary>
        public static Action<string> Report { get; set; } = Console.Error.WriteLine;

        /// <summary>At any time: what came for it before is delivered now.</summary>
        /// <exception cref="UnityAgentsException">Its id is taken.</exception>
        public static void RegisterSideChannel(SideChannel sideChannel)
        {
            var id = sideChannel.ChannelId;
            if (Channels.Exists(one => one.ChannelId == id))
                throw new UnityAgentsException($"channel {id} is registered already: give each its own id");
            Channels.Add(sideChannel);
            var early = Unknown.Where(kept => kept.Id == id).ToArray();
            Unknown.RemoveAll(kept => kept.Id == id);
            Dropped.Remove(id);
            foreach (var (_, message) in early) Deliver(sideChannel, message);
        }

        /// <summary>Does nothing when it is not registered. With the last one goes what was kept for others.</summary>
        public static void UnregisterSideChannel(SideChannel sideChannel)
        {
            if (Channels.Remove(sideChannel) && Channels.Count == 0) Forget();
        }

        internal static void UnregisterAllSideChannels()
        {
            Channels.Clear();
            Forget();
        }

        /// <summary>The queued messages of all channels, by order of registration, then of queueing. A message that
        /// would make it too large stays queued for the next exchange.</summary>
        public static byte[] GetSideChannelMessage()
        {
            var any = false;
            foreach (var channel in Channels) any |= channel.HasMore;
            // Most exchanges are empty, and cost nothing then.
            if (!any) return Array.Empty<byte>();
            using var data = new MemoryStream();
            using var writer = new BinaryWriter(data);
            foreach (var channel in Channels)
                while (channel.TryTake(SideChannel.LargestExchangeBytes - data.Length, out var message))
                {
                    writer.Write(channel.ChannelId.ToByteArray());
                    writer.Write(message.Length);
                    writer.Write(message);
                }
            return data.ToArray();
        }

        /// <summary>Hands received exchanges to their channels. A cut exchange is reported, and does not end the
        /// others.</summary>
        public static void Receive(IEnumerable<byte[]> exchanges)
        {
            foreach (var exchange in exchanges)
            {
                try { ProcessSideChannelData(exchange); }
                catch (UnityAgentsException e) { Report(e.Message); }
            }
        }

        /// <summary>Each message to its channel.</summary>
        /// <exception cref="UnityAgentsException">The last one is cut; those before it are done.</exception>
        public static void ProcessSideChannelData(byte[] dataReceived)
        {
            for (var offset = 0; offset < dataReceived.Length;)
            {
                var left = dataReceived.Length - offset - 20;
                if (left < 0)
                    throw new UnityAgentsException($"an exchange that ends with {left + 20} bytes of a header");
                var id = new Guid(dataReceived.AsSpan(offset, 16));
                var length = BitConverter.ToInt32(dataReceived, offset + 16);
                if (length < 0 || length > left)
                    throw new UnityAgentsException(
                        $"a message to channel {id} of {length} bytes, of which {left} are there");
                var message = dataReceived.AsSpan(offset + 20, length).ToArray();
                offset += 20 + length;
                var channel = Channels.Find(one => one.ChannelId == id);
                if (channel == null) Keep(id, message);
                else Deliver(channel, message);
            }
        }

        // An error in one channel leaves the others alone.
        private static void Deliver(SideChannel channel, byte[] message)
        {
            try { channel.ProcessMessage(message); }
            catch (Exception e)
            {
                var why = e is UnityAgentsException ? e.Message : $"its handler threw {e}";
                Report($"channel {channel.ChannelId}: {why}");
            }
        }

        private static void Forget()
        {
            Unknown.Clear();
            Dropped.Clear();
        }

        private static void Keep(Guid id, byte[] message)
        {
            if (Unknown.Count == MostKeptMessages || message.Length > LargestKeptBytes)
            {
                if (Dropped.Add(id))
                    Report($"unknown channel {id}: too much is kept, and what comes now is dropped; register it");
                return;
            }
            if (!Unknown.Exists(kept => kept.Id == id)) Report($"unknown channel {id}: kept until it is registered");
            Unknown.Add((id, message));
        }
    }

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
