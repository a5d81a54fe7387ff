// ML-Agents' shape, the academy: it steps all agents of the scene, and asks Python for those who want an action.
//
// Use: nothing. The first agent makes it, and from then on each FixedUpdate of Unity is one step:
//
//     requesters ask; steps are counted; who has asked is observed; one exchange with Python; all act; who has had its
//     Max Step ends; then Unity's own physics
//
// Trouble: Unity stands still while Python thinks, as with ML-Agents. A Python that is lost ends Play.
using System;
using System.Collections.Generic;
using NetMQExample.MLAgents.SideChannels;
using UnityEngine;
using Object = UnityEngine.Object;

namespace NetMQExample.MLAgents
{
    public sealed partial class Academy
    {
        // In the order of their OnEnable.
        private readonly List<AgentLife> agents = new List<AgentLife>();
        // Those whose turn it is, while others come and go: in a step, and when all begins anew within it.
        private readonly List<AgentLife> turn = new List<AgentLife>(), beginning = new List<AgentLife>();
        private SceneConnection connection;
        private AcademyStepper stepper;
        private bool begun, stepping, asleep;
        private int ids;

        private static readonly Action<AgentLife> Anew = agent => agent.BeginAnew(), Observe = agent => agent.Observe(),
            Act = agent => agent.Act();

        // True from the end of a Play on: what an OnDisable asks for then must not look for Python once more.
        private static bool over;

        /// <summary>Comes before each step, with the number of steps before it.</summary>
        public event Action<int> AgentPreStep;

        /// <summary>Comes when all begins anew: in the first step, and when Python resets.</summary>
        public event Action OnEnvironmentReset;

        /// <summary>Whether Python decides. That is found out once, when the academy is made.</summary>
        public bool IsCommunicatorOn => connection != null;

        public int StepCount { get; private set; }
        public int TotalStepCount { get; private set; }
        public int EpisodeCount { get; private set; }

        /// <summary>Always 1: nothing copies areas here, and UnityEnvironment refuses more.</summary>
        public int NumAreas => 1;

        /// <summary>Is kept for scripts of ML-Agents: no model runs here.</summary>
        public int InferenceSeed { private get; set; }

        /// <summary>Whether each FixedUpdate is a step; without it a script calls EnvironmentStep.</summary>
        public bool AutomaticSteppingEnabled
        {
            get => stepper != null;
            set
            {
                if (value == AutomaticSteppingEnabled || asleep) return;
                if (!value) Object.Destroy(stepper.gameObject);
                stepper = value ? AcademyStepper.Make() : null;
            }
        }

        /// <summary>Makes one step.</summary>
        /// <exception cref="UnityAgentsException">It was called within a step.</exception>
        public void EnvironmentStep()
        {
            if (stepping)
                throw new UnityAgentsException("EnvironmentStep was called within a step, such as in OnActionReceived: "
                    + "call it in Update, after AutomaticSteppingEnabled = false");
            stepping = true;
            try
            {
                if (!begun) BeginAnew();
                try { AgentPreStep?.Invoke(StepCount); }
                catch (Exception e) { Debug.LogException(e); }
                StepCount++;
                TotalStepCount++;
                foreach (var agent in Turn(turn)) agent.StepCount++;
                Each(turn, Observe);
                Decide();
                Each(turn, Act);
            }
            finally { stepping = false; }
        }

        internal SceneClock Clock => connection?.Clock;

        internal bool IsSteppedBy(AcademyStepper one) => stepper == one;

        internal int Join(AgentLife agent)
        {
            if (Carried && agents.Count == 0 && Application.isPlaying)
                Debug.LogError($"{agent.Name}: a component of this scene, such as a GymManager or one with side "
                    + "channels, has the connection, and ML-Agents' agents stand still. Remove it, or them");
            agents.Add(agent);
            return ids++;
        }

        internal void Leave(AgentLife agent) => agents.Remove(agent);

        partial void Awaken()
        {
            asleep = !Application.isPlaying || over;
            if (asleep) return;
            Application.quitting += End;
#if UNITY_EDITOR
            UnityEditor.AssemblyReloadEvents.beforeAssemblyReload += End;
#endif
            if (Object.FindAnyObjectByType<SteppedBehaviour>() != null
                || Object.FindAnyObjectByType<SideChannelBehaviour>() != null)
            {
                Carried = true;
                return;
            }
            SideChannelManager.Report = new Trouble(Debug.LogWarning).Report;
            Register(EngineSettings.Apply);
            AutomaticSteppingEnabled = true;
            connection = SceneConnection.ToPython();
            if (connection?.Clock.Seed is int seed) UnityEngine.Random.InitState(seed);
        }

        partial void Sleep()
        {
            AutomaticSteppingEnabled = false;
            asleep = true;
            Application.quitting -= End;
#if UNITY_EDITOR
            UnityEditor.AssemblyReloadEvents.beforeAssemblyReload -= End;
#endif
            connection?.Dispose();
            connection = null;
            agents.Clear();
            AgentPreStep = null;
            OnEnvironmentReset = null;
            if (!Carried) SideChannelManager.UnregisterAllSideChannels();
        }

        // Where Unity keeps statics, the Play before this one has set it.
        [RuntimeInitializeOnLoadMethod(RuntimeInitializeLoadType.SubsystemRegistration)]
        private static void BeginPlay()
        {
            over = false;
            // One that was asked for after that, or while nothing played.
            if (instance != null && instance.asleep) instance.Dispose();
        }

        private void End()
        {
            over = true;
            Dispose();
        }

        // Agents that come or go meanwhile have their turn with the next round.
        private List<AgentLife> Turn(List<AgentLife> those)
        {
            those.Clear();
            those.AddRange(agents);
            return those;
        }

        private void Decide()
        {
            var asked = false;
            foreach (var agent in Turn(turn))
            {
                if (agent.IsPythons && !asked)
                {
                    asked = true;
                    if (connection.Exchange()) BeginAnew();
                }
                try { agent.Decide(); }
                catch (Exception e) { agent.Tell(e); }
            }
            // Nobody takes what channels have to say.
            if (connection == null && !Carried) SideChannelManager.GetSideChannelMessage();
        }

        private void BeginAnew()
        {
            StepCount = 0;
            EpisodeCount++;
            begun = true;
            try { OnEnvironmentReset?.Invoke(); }
            catch (Exception e) { Debug.LogException(e); }
            Each(beginning, Anew);
        }

        // An exception in one agent's method is that agent's alone: what the others have told goes to Python, once.
        private void Each(List<AgentLife> those, Action<AgentLife> call)
        {
            foreach (var agent in Turn(those))
                try { call(agent); }
                catch (Exception e) { agent.Tell(e); }
        }
    }
}
