// ML-Agents' shape, what an agent has between its methods: requests, rewards, rows and the order of all that.
//
// An end is observed at once and its row kept for the next exchange; the new episode begins at once, and its first row
// goes when the agent asks. A row's reward is what came since the agent's own last row.
using System;
using System.Collections.Generic;
using NetMQExample.MLAgents.Actuators;
using NetMQExample.MLAgents.Policies;
using NetMQExample.MLAgents.Sensors;
using UnityEngine;

namespace NetMQExample.MLAgents
{
    /// <summary>The inside of one agent.</summary>
    internal sealed class AgentLife
    {
        // Where the sensors write for nobody, so that stacked ones go on.
        private static readonly FrameBuffer Nobody = new FrameBuffer();

        // Those of CollectObservations, or null.
        public VectorSensor Vector;
        public StackingSensor Stacked;
        private readonly Agent agent;
        private SceneKind kind;
        private bool lives, requestsDecision, requestsAction, decides;
        // Whether its last row is one of an end: so it is before it comes.
        private bool ended = true;
        // The name of its own method that is running and in which no episode may end, or null.
        private string within;

        public AgentLife(Agent agent) => (this.agent, Old) = (agent, new AgentOfOld(agent));

        /// <summary>Told once when it leaves: to its group.</summary>
        public event Action<Agent> Left;

        public AgentOfOld Old { get; }
        public string Name => agent.name;
        public BehaviorParameters Parameters => agent.GetComponent<BehaviorParameters>();

        /// <summary>From OnEnable to OnDisable.</summary>
        public int Id { get; private set; }

        /// <summary>The name of its behavior in Python.</summary>
        public string Behavior { get; private set; }

        /// <summary>Whether Python decides for it.</summary>
        public bool IsPythons { get; private set; }

        public ActionSpec Spec { get; private set; }
        public int[] Branches { get; private set; }
        private bool HasActions => Spec.NumContinuousActions + Spec.NumDiscreteActions > 0;

        public List<ISensor> Sensors { get; private set; } = new List<ISensor>();

        public DiscreteActionMask Mask { get; private set; } = new DiscreteActionMask(Array.Empty<int>());

        /// <summary>The actions that it acts by; and the last decision, Python's or its Heuristic's.</summary>
        public ActionBuffers Stored { get; private set; }

        public ActionBuffers Decided { get; private set; }
        public int StepCount { get; set; }
        public int CompletedEpisodes { get; private set; }
        public float CumulativeReward { get; private set; }

        /// <summary>Since its last row, and as that row has it.</summary>
        public float Reward { get; private set; }

        public float RowReward { get; private set; }
        public float GroupReward { get; set; }
        public float RowGroupReward { get; private set; }
        public int GroupId { get; set; }

        public void Begin()
        {
            if (lives) return;
            Spec = Parameters.BrainParameters.ActionSpec;
            Spec.Check(Name);
            Branches = Spec.BranchSizes ?? Array.Empty<int>();
            Mask = new DiscreteActionMask(Branches);
            lives = true;
            var academy = Academy.Instance;
            Stored = new ActionBuffers(Spec);
            Decided = new ActionBuffers(Spec);
            Id = academy.Join(this);
            AgentOfOld.LookForHidden(agent);
            try { agent.Initialize(); }
            finally
            {
                try { Sensors = SensorList.Of(agent, Parameters, out Vector, out Stacked); }
                catch
                {
                    // An agent that does not see all that it should would learn something else.
                    lives = false;
                    academy.Leave(this);
                    throw;
                }
                ended = false;
                Parameters.Changed += ReloadPolicy;
                ReloadPolicy();
            }
            // Until the first step nobody begins: that is for when all are there.
            if (academy.TotalStepCount > 0) BeginEpisode();
        }

        public void End()
        {
            if (!lives) return;
            lives = false;
            Parameters.Changed -= ReloadPolicy;
            // Where the academy is gone, Play is over.
            if (Academy.IsInitialized) Academy.Instance.Leave(this);
            try { if (Academy.IsInitialized) Finish(false, true); }
            finally
            {
                foreach (var sensor in Sensors) (sensor as IDisposable)?.Dispose();
                Left?.Invoke(agent);
            }
        }

        public void Request(bool decision)
        {
            requestsAction = true;
            requestsDecision |= decision;
            // One that never came has an OnEnable of its own.
            if (!lives && agent.isActiveAndEnabled) AgentOfOld.LookForHidden(agent);
        }

        public void Earn(float reward, bool replaces)
        {
            if (replaces) reward -= Reward;
            Reward += reward;
            CumulativeReward += reward;
        }

        public void EndEpisode(string method, bool interrupted)
        {
            if (within != null)
                throw new UnityAgentsException($"{agent.name}: {method} was called in {within}: call it in "
                    + "OnActionReceived, or where the scene finds the end");
            Finish(interrupted, false);
            BeginAnew();
        }

        public void BeginAnew()
        {
            Stored.Clear();
            Mask.Clear();
            StepCount = 0;
            BeginEpisode();
        }

        /// <summary>Says what one of its methods has thrown.</summary>
        public void Tell(Exception mistake) => Debug.LogException(mistake, agent);

        public void Observe()
        {
            if (!requestsDecision || !lives) return;
            Collect();
            Mask.Clear();
            if (lives && Spec.NumDiscreteActions > 0) agent.WriteDiscreteActionMask(Mask);
            // It may have left meanwhile.
            if (!lives) return;
            Mask.Check();
            ended = false;
            RowReward = Reward;
            RowGroupReward = GroupReward;
            Tell(true, false);
            Reward = GroupReward = 0;
            requestsDecision = false;
        }

        public void Decide()
        {
            if (!lives) return;
            if (decides && !IsPythons)
            {
                Decided.Clear();
                if (HasActions) agent.Heuristic(Decided);
            }
            decides = false;
            Decided.ContinuousActions.Array.CopyTo(Stored.ContinuousActions.Array, 0);
            Decided.DiscreteActions.Array.CopyTo(Stored.DiscreteActions.Array, 0);
        }

        public void Act()
        {
            if (!lives) return;
            var acts = requestsAction && HasActions;
            requestsAction = false;
            if (acts) agent.OnActionReceived(Stored);
            if (agent.MaxStep <= 0 || StepCount < agent.MaxStep) return;
            Finish(true, false);
            BeginAnew();
        }

        // The last row of an episode; a second end before the next decision has none.
        public void Finish(bool interrupted, bool leaves)
        {
            if (ended) return;
            ended = true;
            // What is earned while it is seen for the last time is lost.
            RowReward = Reward;
            RowGroupReward = GroupReward;
            Collect();
            Tell(false, interrupted);
            foreach (var sensor in Sensors) sensor.Reset();
            if (!leaves) CompletedEpisodes++;
            Reward = GroupReward = CumulativeReward = 0;
            requestsAction = requestsDecision = false;
        }

        private void Collect()
        {
            foreach (var sensor in Sensors) sensor.Update();
            within = nameof(Agent.CollectObservations);
            try { agent.CollectObservations(Vector); }
            finally { within = null; }
        }

        private void BeginEpisode()
        {
            within = nameof(Agent.OnEpisodeBegin);
            try { agent.OnEpisodeBegin(); }
            finally { within = null; }
        }

        // With a row Python's last decision counts no more; a heuristic's stays until its next one.
        private void Tell(bool wants, bool interrupted)
        {
            var clock = Academy.Instance.Clock;
            decides = wants;
            if (!IsPythons || clock == null)
            {
                Nobody.Clear();
                // A picture that nobody sees costs too much.
                foreach (var sensor in Sensors)
                    if (!SensorRows.IsPicture(sensor)) SensorRows.Write(sensor, Nobody);
                return;
            }
            kind ??= clock.KindOf(this);
            if (wants) kind.Want(this);
            else kind.End(this, interrupted);
            clock.HasRows = true;
            Decided.Clear();
        }

        private void ReloadPolicy()
        {
            IsPythons = Parameters.BehaviorType == BehaviorType.Default && Academy.Instance.IsCommunicatorOn;
            Behavior = Parameters.FullyQualifiedBehaviorName;
            kind = null;
            Decided.Clear();
        }
    }
}
