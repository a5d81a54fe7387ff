// Lesson 09, the environment itself, for scripts that are no agents, with the names that gymize has.
//
//     GymEnv.OnInfo += info => Debug.Log(info);         Python's env.unwrapped.send_info("hello")
//     GymEnv.SendInfo("a goal");                        in the next info["env"]
//     GymEnv.Terminate();                               the episode is over for every agent
using System;

namespace NetMQExample
{
    /// <summary>Speaks for all agents of the scene, or for one by its name. For the main thread.</summary>
    public static class GymEnv
    {
        private static SceneSimulator simulator;

        /// <summary>Python's infos to the environment. A component that is destroyed removes its handler.</summary>
        public static event Action<object> OnInfo;

        /// <summary>Of the newest GymManager, which sets it.</summary>
        /// <exception cref="InvalidOperationException">There is none.</exception>
        public static SceneSimulator Simulator
        {
            get => simulator ?? throw new InvalidOperationException(
                "there is no GymManager in the scene: put one on any game object");
            set
            {
                simulator = Require.Given("Simulator", value);
                simulator.Others = () => OnInfo;
            }
        }

        /// <inheritdoc cref="SceneSimulator.SendInfo"/>
        public static void SendInfo(object info) => Simulator.SendInfo(info);

        /// <summary>Tells Python something of an agent, with its next answer.</summary>
        public static void SendInfo(string agent, object info)
        {
            if (agent == "") SendInfo(info);
            else Simulator.Find(agent).AgentState.SendInfo(info);
        }

        public static void AddReward(string agent, double reward) => Simulator.Find(agent).AgentState.AddReward(reward);
        public static void SetReward(string agent, double reward) => Simulator.Find(agent).AgentState.SetReward(reward);

        /// <summary>The episode is over for one agent; without a name for all.</summary>
        public static void Terminate(string agent = "")
        {
            if (agent == "") Simulator.Terminate();
            else Simulator.Find(agent).AgentState.Terminate();
        }

        /// <summary>The same, for another reason, such as the time.</summary>
        public static void Truncate(string agent = "")
        {
            if (agent == "") Simulator.Truncate();
            else Simulator.Find(agent).AgentState.Truncate();
        }
    }
}
