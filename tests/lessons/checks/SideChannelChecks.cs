// test_13_side_channels_bytes.py asks this of the C# side. Each line of the input is answered with one line:
//
//     read PAYLOAD b i f s l r    what is read of a message, value by value: numbers as bits, texts as UTF-8, in digits
//     write b:1 i:-5 s:68 u:c3a9  the message with these values
//     process EXCHANGE            what all channels make of it: lines, what is drawn of parameters, what they send
//     half -                      what is made of half a character
//     keep COUNT                  what is left of so many messages that nobody took
//
// And `settings EXCHANGE`, what Unity has then, `steps --endpoint ENDPOINT`, a simulator of lesson 09,
// `plain --endpoint ENDPOINT`, the same without side channels, and `pictures ENDPOINT COUNT`.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using System.Text;
using NetMQExample.MLAgents;
using NetMQExample.MLAgents.SideChannels;
using UnityEngine;

namespace NetMQExample.Tests
{
    internal static class SideChannelChecks
    {
        public static void Run(string[] words)
        {
            Program.WriteNumbersInGerman();
            if (words.Length > 0 && words[0] == "steps") Steps(words[2], one => new SideChannelSimulator(one));
            else if (words.Length > 0 && words[0] == "plain") Steps(words[2], one => one);
            else if (words.Length == 2 && words[0] == "settings") Settings(Hex.Bytes(words[1]));
            else if (words.Length == 3) Pictures(words[1], int.Parse(words[2]));
            else Program.EachLine(line => Answer(line.Split(' ')));
        }

        private static string Answer(string[] words)
        {
            try
            {
                switch (words[0])
                {
                    case "read": return Read(Hex.Bytes(words[1]), words.Skip(2));
                    case "write": return Hex.Digits(Write(words.Skip(1)));
                    case "process": return Process(Hex.Bytes(words[1]));
                    case "half": return Half();
                    default: return Keep(int.Parse(words[1], CultureInfo.InvariantCulture));
                }
            }
            catch (UnityAgentsException e) { return $"error {e.Message}"; }
        }

        private static string Read(byte[] payload, IEnumerable<string> kinds)
        {
            using var message = new IncomingMessage(payload);
            string Value(string kind) => kind switch
            {
                "b" => message.ReadBoolean() ? "1" : "0",
                "i" => message.ReadInt32().ToString(CultureInfo.InvariantCulture),
                "f" => Bits(message.ReadFloat32()),
                "s" => Hex.Digits(Encoding.UTF8.GetBytes(message.ReadString(""))),
                "l" => string.Join(",", message.ReadFloatList(new float[0]).Select(Bits)),
                _ => Hex.Digits(message.GetRawBytes()),
            };
            return string.Join(" ", kinds.Select(Value));
        }

        private static byte[] Write(IEnumerable<string> values)
        {
            using var message = new OutgoingMessage();
            foreach (var value in values)
            {
                var text = value.Substring(2);
                if (value[0] == 'b') message.WriteBoolean(text == "1");
                else if (value[0] == 'i') message.WriteInt32(int.Parse(text, CultureInfo.InvariantCulture));
                else if (value[0] == 'f') message.WriteFloat32(Single(text));
                else if (value[0] == 's') message.WriteString(Encoding.UTF8.GetString(Hex.Bytes(text)));
                else if (value[0] == 'u') message.WriteString(Encoding.UTF8.GetString(Hex.Bytes(text)), utf8: true);
                else if (value[0] == 'l')
                    message.WriteFloatList(text == "" ? new float[0] : text.Split(',').Select(Single).ToArray());
                else message.SetRawBytes(Hex.Bytes(text));
            }
            var channel = new RawBytesChannel(Guid.Empty);
            SideChannelManager.RegisterSideChannel(channel);
            var lines = new List<string>();
            SideChannelManager.Report = lines.Add;
            channel.QueueForTest(message);
            var data = SideChannelManager.GetSideChannelMessage();
            SideChannelManager.UnregisterSideChannel(channel);
            return lines.Count == 0 ? data.Skip(20).ToArray() : throw new UnityAgentsException(lines[0].Split(", ")[1]);
        }

        // It is not sent, and without an exception, which would come out of the game's own Debug.LogError. What follows
        // is.
        private static string Half()
        {
            var (log, lines) = (new RawBytesChannel(new Guid("621f0a70-4f87-11ea-a6bf-784f4387d1f7")),
                new List<string>());
            SideChannelManager.Report = lines.Add;
            SideChannelManager.RegisterSideChannel(log);
            using var half = new OutgoingMessage();
            half.WriteString("a\ud800b");
            log.QueueForTest(half);
            log.SendRawBytes(new byte[3]);
            var sent = SideChannelManager.GetSideChannelMessage();
            SideChannelManager.UnregisterSideChannel(log);
            throw new UnityAgentsException(sent.Length == 23 ? lines.Single() : $"sent {sent.Length} bytes");
        }

        // Messages are queued while nobody takes them.
        private static string Keep(int count)
        {
            var (channel, lines) = (new RawBytesChannel(new Guid("00112233-4455-6677-8899-aabbccddeeff")),
                new List<string>());
            SideChannelManager.Report = lines.Add;
            SideChannelManager.RegisterSideChannel(channel);
            for (var i = 0; i < count; i++) channel.SendRawBytes(new[] { (byte)(i >> 16), (byte)(i >> 8), (byte)i });
            var sent = SideChannelManager.GetSideChannelMessage();
            SideChannelManager.UnregisterSideChannel(channel);
            return $"{string.Join("|", lines)} {sent.Length / 23} {Hex.Digits(sent.Skip(20).Take(3).ToArray())}";
        }

        private static string Process(byte[] exchange)
        {
            var lines = new List<string>();
            void Say(string line) => lines.Add(line);
            SideChannelManager.Report = Say;
            var channels = new SideChannel[] { new StringLogChannel(Say), new FloatPropertiesChannel(),
                new RawBytesChannel(new Guid(new byte[16])) };
            foreach (var channel in channels) SideChannelManager.RegisterSideChannel(channel);
            var academy = Academy.Instance;
            // Mono writes no more than 15 digits of a number.
            academy.Begin((kind, values) =>
                Say(values[0] < 1e15 ? EngineConfigurationChannel.Describe(kind, values) : Bits((float)values[0])));
            SideChannelManager.Receive(new[] { exchange });
            var late = new RawBytesChannel(new Guid("00112233-4455-6677-8899-aabbccddeeff"));
            SideChannelManager.RegisterSideChannel(late);
            foreach (var message in late.GetAndClearReceivedMessages()) Say($"late {Hex.Digits(message)}");
            SideChannelManager.UnregisterSideChannel(late);
            var properties = (FloatPropertiesChannel)channels[1];
            foreach (var key in properties.Keys()) Say($"{key}={Bits(properties.GetWithDefault(key, 0))}");
            var parameters = academy.EnvironmentParameters;
            foreach (var key in parameters.Keys())
            {
                var drawn = Enumerable.Range(0, 3).Select(_ => Bits(parameters.GetWithDefault(key, 0)));
                Say($"{key}:{string.Join(",", drawn)}");
            }
            foreach (var message in ((RawBytesChannel)channels[2]).GetAndClearReceivedMessages())
                Say(Hex.Digits(message));
            Array.ForEach(channels, SideChannelManager.UnregisterSideChannel);
            academy.Dispose();
            return Hex.Digits(Encoding.UTF8.GetBytes(string.Join("\n", lines)));
        }

        private static void Settings(byte[] exchange)
        {
            Academy.Instance.Begin(EngineSettings.Apply);
            SideChannelManager.ProcessSideChannelData(exchange);
            Console.WriteLine(
                FormattableString.Invariant($"{Time.timeScale} {Application.targetFrameRate} {Time.captureFramerate}"));
        }

        private static void Steps(string endpoint, Func<SimulatorBase, SimulatorBase> carrying)
        {
            Academy.Instance.Begin((kind, values) => { });
            using var client = new EnvironmentClient(endpoint, TimeSpan.FromSeconds(20), Console.WriteLine);
            client.Run(carrying(new SceneSimulator("Moon", 0.02, new[] { new Moon() })), 0, answer => answer());
        }

        private static void Pictures(string endpoint, int count)
        {
            var pictures = new RawBytesChannel(new Guid("00112233-4455-6677-8899-aabbccddeeff"));
            SideChannelManager.RegisterSideChannel(pictures);
            using var carrier = new SideChannelCarrier(endpoint, TimeSpan.FromSeconds(20));
            var (sent, seen) = (0, 0);
            while (seen < count)
            {
                // Ten at the most are on their way.
                for (; sent < count && sent < seen + 10; sent++)
                    pictures.SendRawBytes(Enumerable.Repeat((byte)sent, 128 * 128 * 3).ToArray());
                SideChannelManager.Receive(
                    carrier.Exchange(SideChannelManager.GetSideChannelMessage(), TimeSpan.FromMilliseconds(10)));
                seen += pictures.GetAndClearReceivedMessages().Count;
            }
        }

        private static void QueueForTest(this RawBytesChannel channel, OutgoingMessage message) =>
            typeof(SideChannel).GetMethod("QueueMessageToSend",
                System.Reflection.BindingFlags.Instance | System.Reflection.BindingFlags.NonPublic)
                .Invoke(channel, new object[] { message });

        private static string Bits(float value) =>
            float.IsNaN(value)
                ? "nan"
                : BitConverter.ToInt32(BitConverter.GetBytes(value), 0).ToString("x8", CultureInfo.InvariantCulture);

        private static float Single(string bits) =>
            BitConverter.ToSingle(BitConverter.GetBytes(Convert.ToInt32(bits, 16)), 0);
    }

    // It sees the gravity that its reset knew of, and records each action.
    internal sealed class Moon : PlainAgent
    {
        private double gravity;

        public override GymSpace Observation { get; } = GymSpace.Box(new[] { 0.0 }, new[] { 100.0 });
        public override GymSpace Action { get; } = GymSpace.Discrete(9);
        protected override int StateSize => 1;

        public override void OnReset() => gravity =
            FirstState.Length + Academy.Instance.EnvironmentParameters.GetWithDefault("gravity", 9.75f);

        public override void OnAction(SpaceReader action) =>
            Academy.Instance.StatsRecorder.Add("action", (float)action[0], StatAggregationMethod.Sum);

        public override void Observe(SpaceWriter seen) => seen.Add(gravity);
    }
}
