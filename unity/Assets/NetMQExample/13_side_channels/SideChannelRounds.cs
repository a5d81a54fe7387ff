// Lesson 13, a simulation that uses its channels, for the scene and for the terminal.
//
// In each round it draws its parameters, records statistics and sets a property; the server's property says that it has
// seen that. The Python side is rounds.py, with the same lines and numbers.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Linq;

namespace NetMQExample.MLAgents.SideChannels
{
    /// <summary>A number of rounds. For one thread, in Unity the main thread.</summary>
    public sealed class SideChannelRounds : IDisposable
    {
        private static readonly string[] Troubles = { "none", "unknown", "cut", "throw" };

        private readonly int count;
        private readonly TimeSpan limit;
        private readonly Stopwatch looked = Stopwatch.StartNew();
        private readonly Action<string> log;
        private readonly FloatPropertiesChannel properties = new FloatPropertiesChannel();
        private readonly RawBytesChannel stranger = new RawBytesChannel(
            new Guid("00112233-4455-6677-8899-aabbccddeeff"));
        private string trouble;
        private int round;
        // For how many seconds it is not seen.
        private double waited;

        /// <summary>Registers its channels. The trouble is none, unknown, cut or throw; a round takes so long at most.
        /// </summary>
        /// <exception cref="ArgumentException">There is no such trouble.</exception>
        public SideChannelRounds(int count, string trouble, TimeSpan limit, Action<string> log)
        {
            if (!Troubles.Contains(trouble))
                throw new ArgumentException($"trouble is one of {string.Join(", ", Troubles)}, not '{trouble}'");
            Require.Given("log", log);
            this.count = count;
            this.trouble = trouble;
            this.limit = limit;
            this.log = line => log(LogText.Printable(line));
            StringLog = new StringLogChannel(this.log, trouble == "throw");
            SideChannelManager.Report = new Trouble(this.log).Report;
            Academy.Instance.EnvironmentParameters.RegisterCallback("gravity", value => log(
                $"gravity is now {Shown(value, "F2")}"));
            SideChannelManager.RegisterSideChannel(StringLog);
            SideChannelManager.RegisterSideChannel(properties);
        }

        /// <summary>For errors on their way to Python.</summary>
        public StringLogChannel StringLog { get; }

        /// <summary>True once the server has seen the last one.</summary>
        public bool Done => round >= count && Seen;

        // Whether the server has said that it knows of this round; before the first one, that it is there.
        private bool Seen => properties.GetWithDefault("seen", -1) == round;

        /// <summary>Hands the received exchanges to the channels, and returns the one that they have queued.</summary>
        /// <exception cref="TimeoutException">Nobody sees this round.</exception>
        public byte[] Exchange(List<byte[]> received)
        {
            SideChannelManager.Receive(received);
            // A longer gap than a second was sleep.
            waited += Math.Min(looked.Elapsed.TotalSeconds, 1);
            looked.Restart();
            if (Seen && round < count) BeginRound();
            else if (!Seen && waited > limit.TotalSeconds)
                throw new TimeoutException(FormattableString.Invariant(
                    $"round {round} was not seen within {limit.TotalSeconds} s; is that lesson 13's server?"));
            // A server that was started again has not heard of this round.
            else if (!Seen && received.Count > 0) properties.Set("round", round);
            var data = SideChannelManager.GetSideChannelMessage();
            if (trouble != "cut" || data.Length == 0) return data;
            trouble = "none";
            // Nine bytes are announced, and six come.
            var cut = new byte[] { 9, 0, 0, 0, 5, 0, 0, 0, (byte)'H', (byte)'e' };
            return data.Concat(StringLog.ChannelId.ToByteArray()).Concat(cut).ToArray();
        }

        public void Dispose()
        {
            SideChannelManager.UnregisterSideChannel(StringLog);
            SideChannelManager.UnregisterSideChannel(properties);
            SideChannelManager.UnregisterSideChannel(stranger);
        }

        // NaN and infinity have the names that Python has for them.
        private static string Shown(float value, string format) =>
            float.IsNaN(value) ? "nan"
            : float.IsInfinity(value) ? (value > 0 ? "inf" : "-inf")
            : value.ToString(format, System.Globalization.CultureInfo.InvariantCulture);

        private static float Draw(string key) => Academy.Instance.EnvironmentParameters.GetWithDefault(key, 0);

        private void BeginRound()
        {
            round++;
            waited = 0;
            var (mass, wind, light) = (Draw("mass"), Draw("wind"), Draw("light"));
            log($"{round}: mass {Shown(mass, "F4")}, wind {Shown(wind, "F4")}, light {Shown(light, "F4")}");
            Academy.Instance.StatsRecorder.Add("mass", mass);
            Academy.Instance.StatsRecorder.Add("rounds", 1, StatAggregationMethod.Sum);
            if (round == count) StringLog.SendDebugStatementToPython("Error: a fake error in the last round");
            if (trouble == "unknown")
            {
                trouble = "none";
                SideChannelManager.RegisterSideChannel(stranger);
                stranger.SendRawBytes(IncomingMessage.Utf8.GetBytes("is anybody there?"));
            }
            properties.Set("round", round);
        }
    }
}
