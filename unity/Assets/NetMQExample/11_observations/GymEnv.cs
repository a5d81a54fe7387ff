// Lesson 11 in Unity: the environment itself, for scripts that are no agents, with the names that gymize has.
//
//     GymEnv.OnInfo += info => Debug.Log(info);         Python's env.unwrapped.send_info("hello")
//     GymEnv.SendInfo("a goal");                        in the next info["env"]
//     GymEnv.Terminate();                               the episode is over for every agent
using System;
using System.Linq;

namespace NetMQExample
{
    /// <summary>What concerns all agents of the scene, or one that is named. For the main thread.</summary>
    public static class GymEnv
    {
        /// <summary>Hears what Python sends to the environment. Whoever is destroyed takes his handler away.</summary>
        public static event Action<object> OnInfo;

        /// <summary>Tells Python something of the environment, with the next answer.</summary>
        /// <exception cref="MessageException">It has no place in a message.</exception>
        /// <exception cref="InvalidOperationException">There is no GymManager.</exception>
        public static void SendInfo(object info) => Environment.SendInfo(info);

        /// <summary>Tells Python something of an agent, with its next answer.</summary>
        public static void SendInfo(string agent, object info)
        {
            if (agent == "") SendInfo(info);
            else Find(agent).SendInfo(info);
        }

        /// <summary>Adds to an agent's reward.</summary>
        public static void AddReward(string agent, double reward) => Find(agent).AddReward(reward);

        /// <summary>Replaces an agent's reward.</summary>
        public static void SetReward(string agent, double reward) => Find(agent).SetReward(reward);

        /// <summary>The episode is over for one agent; without a name for all.</summary>
        public static void Terminate(string agent = "")
        {
            if (agent == "") Environment.Terminate();
            else Find(agent).Terminate();
        }

        /// <summary>The same, for another reason, such as the time.</summary>
        public static void Truncate(string agent = "")
        {
            if (agent == "") Environment.Truncate();
            else Find(agent).Truncate();
        }

        internal static void Hear(object info) => OnInfo?.Invoke(info);

        private static SceneSimulator Environment => GymManager.Current?.Simulator
            ?? throw new InvalidOperationException("there is no GymManager in the scene: put one on any game object");

        private static AgentState Find(string agent) =>
            Agent.All.FirstOrDefault(one => one.State.Name == agent)?.State
            ?? throw new ArgumentException($"no agent is named '{agent}'; there are: "
                + string.Join(", ", Agent.All.Select(one => one.State.Name)));
    }
}
