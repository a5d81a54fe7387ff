// Deeds: what agents do in their calls, each a word of the test.
//
//     "A act 3: add 1, end"        in its third OnActionReceived the agent A adds a reward of 1 and ends its episode
//     "A see *: B>add 2"           in each of its CollectObservations it gives B a reward of 2
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using NetMQExample.MLAgents;
using NetMQExample.MLAgents.Actuators;
using NetMQExample.MLAgents.Inference;
using UnityEngine;
using Object = UnityEngine.Object;

namespace MLAgentsWorlds
{
    internal static class Deeds
    {
        private static readonly Dictionary<string, string> All = new Dictionary<string, string>();
        private static readonly Dictionary<string, SimpleMultiAgentGroup> Groups =
            new Dictionary<string, SimpleMultiAgentGroup>();

        /// <summary>Of the agent whose WriteDiscreteActionMask is running.</summary>
        public static IDiscreteActionMask Mask { get; set; }

        public static void Add(string word)
        {
            var parts = word.Split(new[] { ": " }, 2, StringSplitOptions.None);
            All.Add(parts[0], parts[1]);
        }

        /// <summary>Those of a Play before, where statics are kept.</summary>
        public static void Clear()
        {
            All.Clear();
            Groups.Clear();
        }

        public static bool Any(Agent agent, string call, int number) => Of(agent, call, number).Any();

        /// <summary>Does what there is to do, and tells what was thrown.</summary>
        public static void Do(Agent agent, string call, int number)
        {
            foreach (var deed in Of(agent, call, number).SelectMany(all => all.Split(new[] { ", " },
                StringSplitOptions.None)))
                try
                {
                    var at = deed.IndexOf('>');
                    Do(at < 0 ? agent : Worlds.Agents[deed.Substring(0, at)], deed.Substring(at + 1).Split(' '));
                }
                catch (Exception e) { Told.Write($"{agent.name} threw {e.GetType().Name}: {e.Message}"); }
        }

        private static IEnumerable<string> Of(Agent agent, string call, int number)
        {
            if (All.TryGetValue($"{agent.name} {call} {number}", out var then)) yield return then;
            if (All.TryGetValue($"{agent.name} {call} *", out var always)) yield return always;
        }

        private static void Do(Agent agent, string[] words)
        {
            switch (words[0])
            {
                case "add": agent.AddReward(Number(words[1])); break;
                case "set": agent.SetReward(Number(words[1])); break;
                case "sum": Told.Write(Told.Invariant($"{agent.name} sum {agent.GetCumulativeReward()}")); break;
                case "end": agent.EndEpisode(); break;
                case "interrupt": agent.EpisodeInterrupted(); break;
                case "ask": agent.RequestDecision(); break;
                case "request": agent.RequestAction(); break;
                case "on": agent.gameObject.SetActive(true); break;
                case "off": agent.gameObject.SetActive(false); break;
                case "copy": Told.Write($"copied {Object.Instantiate(agent.gameObject).name}"); break;
                case "make":
                    Worlds.Make(words[1]);
                    Told.Write($"made {words[1]}");
                    break;
                case "join":
                    if (!Groups.ContainsKey(words[1])) Groups[words[1]] = new SimpleMultiAgentGroup();
                    Groups[words[1]].RegisterAgent(agent);
                    break;
                case "leave": Groups[words[1]].UnregisterAgent(agent); break;
                case "group-add": Groups[words[1]].AddGroupReward(Number(words[2])); break;
                case "group-set": Groups[words[1]].SetGroupReward(Number(words[2])); break;
                case "group-end": Groups[words[1]].EndGroupEpisode(); break;
                case "group-interrupt": Groups[words[1]].GroupEpisodeInterrupted(); break;
                case "group-size": Told.Write($"{Groups[words[1]].GetRegisteredAgents().Count} in {words[1]}"); break;
                case "forbid": Mask.SetActionEnabled(int.Parse(words[1]), int.Parse(words[2]), false); break;
                case "forbid-all": Mask.WriteMask(int.Parse(words[1]), words.Skip(2).Select(int.Parse)); break;
                case "model": agent.SetModel("Ball", ScriptableObject.CreateInstance<NNModel>()); break;
                case "step": Academy.Instance.EnvironmentStep(); break;
                case "automatic": Academy.Instance.AutomaticSteppingEnabled = words[1] == "on"; break;
                default: Told.Write(Asked(words)); break;
            }
        }

        private static string Asked(string[] words) => words[0] switch
        {
            "random" => Told.Invariant($"random {UnityEngine.Random.value:R}"),
            "parameter" => Told.Invariant(
                $"{words[1]} {Academy.Instance.EnvironmentParameters.GetWithDefault(words[1], -1)}"),
            "physics" => $"physics by {Physics.simulationMode}",
            "python" => $"python {Academy.Instance.IsCommunicatorOn}",
            "academy" => $"academy {Academy.Instance.StepCount} {Academy.Instance.TotalStepCount} "
                + $"{Academy.Instance.EpisodeCount}",
            _ => throw new ArgumentException($"no such deed: {words[0]}"),
        };

        private static float Number(string word) => float.Parse(word, CultureInfo.InvariantCulture);
    }
}
