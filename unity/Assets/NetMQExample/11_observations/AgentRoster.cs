// Lesson 11, who takes part: one agent for each name.
//
// A name is free when its holder has left, or when its episode is over. Unity destroys a game object at the end of the
// frame only: so another agent of its name, which a script makes just before that, waits for a frame.
using System;
using System.Collections.Generic;

namespace NetMQExample
{
    /// <summary>For one thread, in Unity the main thread.</summary>
    internal static class AgentRoster
    {
        private static readonly List<(IAgent Agent, bool Again)> Waiting = new List<(IAgent, bool)>();
        private static readonly List<(IAgent Agent, string Name, string Why)> Refused =
            new List<(IAgent, string, string)>();

        /// <summary>All that take part now.</summary>
        public static List<IAgent> All { get; } = new List<IAgent>();

        /// <summary>Whether somebody waits for a name.</summary>
        public static bool Unsettled => Waiting.Count > 0;

        /// <summary>An agent comes.</summary>
        public static void Join(IAgent agent)
        {
            Refused.RemoveAll(one => one.Agent == agent);
            if (!TryJoin(agent)) Waiting.Add((agent, false));
        }

        /// <summary>An agent leaves.</summary>
        /// <returns>False if it had no part.</returns>
        public static bool Leave(IAgent agent)
        {
            Refused.RemoveAll(one => one.Agent == agent);
            var waited = Waiting.RemoveAll(one => one.Agent == agent) > 0;
            return All.Remove(agent) || waited;
        }

        /// <summary>It has no part until it comes again.</summary>
        public static void Refuse(IAgent agent, string name, string why) => Refused.Add((agent, name, why));

        /// <summary>Throws if an agent of this name was refused, and exists.</summary>
        /// <exception cref="MessageException">It says why.</exception>
        public static void Check(string name, Func<IAgent, bool> exists)
        {
            var why = Refused.Find(one => one.Name == name && exists(one.Agent)).Why;
            if (why != null) throw new MessageException("wrong-agent", why);
        }

        /// <summary>Once in each frame: who waits for a name has it now, or is refused.</summary>
        public static void Settle(Action<IAgent> refuse)
        {
            if (Waiting.Count == 0) return;
            var before = Waiting.ToArray();
            Waiting.Clear();
            foreach (var (agent, again) in before)
            {
                if (TryJoin(agent)) continue;
                if (again) refuse(agent);
                else Waiting.Add((agent, true));
            }
        }

        private static bool TryJoin(IAgent agent)
        {
            // Made also for the only agent: what is wrong with its members is said now.
            var name = agent.State.Name;
            var other = All.Find(one => one.State.Name == name);
            if (other != null && !other.State.Over) return false;
            All.Remove(other);
            All.Add(agent);
            return true;
        }
    }
}
