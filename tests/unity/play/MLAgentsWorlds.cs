// Worlds of ML-Agents' shape, the scene's clock: agents tell what happens to them, as lines that begin with |.
//
//     … play.dll clock "A period=2 numbers=1" "A act 3: add 1, end" --mlagents-port 5005     until Python is gone
//     … play.dll clock "A period=2 numbers=1" steps=10                                       ten steps without Python
//
// An agent has a name and what its inspector has; MLAgentsDeeds.cs has what it may do. With a port it begins when
// somebody listens there.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using System.Net.Sockets;
using System.Threading;
using NetMQExample;
using NetMQExample.MLAgents;
using NetMQExample.MLAgents.Actuators;
using NetMQExample.MLAgents.Policies;
using NetMQExample.MLAgents.Sensors;
using UnityEngine;
using UnityPlayer;
using Agent = NetMQExample.MLAgents.Agent;

namespace MLAgentsWorlds
{
    internal static class Worlds
    {
        private static readonly TimeSpan Limit = TimeSpan.FromSeconds(60);
        private static readonly Dictionary<string, Dictionary<string, string>> Wanted =
            new Dictionary<string, Dictionary<string, string>>();

        public static Dictionary<string, Agent> Agents { get; } = new Dictionary<string, Agent>();

        public static int Run(string[] words)
        {
            var steps = int.MaxValue;
            // Of a Play before, where statics are kept.
            Wanted.Clear();
            Agents.Clear();
            Deeds.Clear();
            foreach (var word in words.TakeWhile(word => !word.StartsWith("--", StringComparison.Ordinal)))
                if (word.Contains(": ")) Deeds.Add(word);
                else if (word.StartsWith("steps=", StringComparison.Ordinal)) steps = int.Parse(word.Substring(6));
                else Want(word);
            var at = Array.IndexOf(words, "--mlagents-port") + 1;
            if (at > 0 && steps == int.MaxValue) WaitFor(int.Parse(words[at]));
            var player = new Player(typeof(NetMQLifetime).Assembly);
            player.Begin(() =>
            {
                foreach (var name in Wanted.Keys.Where(name => !Wanted[name].ContainsKey("late"))) Make(name);
                Academy.Instance.OnEnvironmentReset += () => Told.Write("reset");
                Academy.Instance.AgentPreStep += number => Told.Write($"step {number}");
            });
            // Each frame has one FixedUpdate, the first one two, and comes at once.
            Time.captureFramerate = 50;
            QualitySettings.vSyncCount = 0;
            player.Run(Limit, () => Academy.IsInitialized && Academy.Instance.TotalStepCount >= steps, false);
            Told.Write("stop");
            player.Stop();
            return player.Errors > 0 ? 1 : 0;
        }

        /// <summary>Makes an agent as it was wanted.</summary>
        public static void Make(string name)
        {
            var wanted = Wanted[name];
            string Of(string key, string other) => wanted.TryGetValue(key, out var value) ? value : other;
            int Number(string key, int other) => int.Parse(Of(key, $"{other}"), CultureInfo.InvariantCulture);
            var thing = new GameObject(name);
            thing.SetActive(false);
            var parameters = thing.AddComponent<BehaviorParameters>();
            parameters.BehaviorName = Of("behavior", "Ball");
            parameters.TeamId = Number("team", 0);
            parameters.BehaviorType = (BehaviorType)Enum.Parse(typeof(BehaviorType), Of("type", "Default"));
            parameters.BrainParameters.VectorObservationSize = Number("size", 1);
            parameters.BrainParameters.NumStackedVectorObservations = Number("stack", 1);
            var branches = Of("branches", "").Split(new[] { 'x' }, StringSplitOptions.RemoveEmptyEntries);
            parameters.BrainParameters.ActionSpec = new ActionSpec(
                Number("numbers", branches.Length > 0 ? 0 : 1), branches.Select(int.Parse).ToArray());
            var script = typeof(Told).Assembly.GetType($"MLAgentsWorlds.{Of("class", "Told")}");
            var agent = (Agent)thing.AddComponent(script);
            Agents[name] = agent;
            agent.MaxStep = Number("max", 0);
            if (agent is Told told) told.see = Number("size", 1);
            if (wanted.ContainsKey("broken")) thing.AddComponent<Broken>();
            if (wanted.ContainsKey("solid"))
            {
                thing.AddComponent<SphereCollider>().isTrigger = true;
                thing.AddComponent<Rigidbody>().useGravity = false;
            }
            // An agent asks for itself where no period is given.
            if (wanted.ContainsKey("period"))
            {
                var requester = thing.AddComponent<DecisionRequester>();
                requester.DecisionPeriod = Number("period", 1);
                requester.DecisionStep = Number("offset", 0);
                requester.TakeActionsBetweenDecisions = Of("between", "yes") == "yes";
            }
            thing.SetActive(Of("active", "yes") == "yes");
        }

        private static void Want(string word)
        {
            var parts = word.Split(' ');
            var settings = parts.Skip(1).Select(part => part.Split('='));
            Wanted.Add(parts[0], settings.ToDictionary(part => part[0], part => part.Last()));
        }

        private sealed class Broken : NetMQExample.MLAgents.Sensors.SensorComponent
        {
            public override ISensor[] CreateSensors() => throw new InvalidOperationException("no eye");
        }

        private static void WaitFor(int port)
        {
            for (var tries = 0; tries < 10000; tries++, Thread.Sleep(2))
                try
                {
                    using var probe = new TcpClient("127.0.0.1", port);
                    return;
                }
                catch (SocketException)
                {
                    // Python is still getting ready.
                }
        }
    }
}
