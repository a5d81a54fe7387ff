// Lesson 10 in Unity: derive from this, and Python decides when time passes for all agents of your scene.
//
// Use: start a Python program that makes the environment, add your component to any GameObject, press Play. To play by
// hand, without Python, tick By Hand. How it goes with physics and frames, see SteppedBehaviour.cs.
using System.Collections.Generic;
using System.Linq;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>A scene as a PettingZoo environment: declare the agents and their spaces, then write reset, apply,
    /// observe, reward and end.</summary>
    public abstract class PythonAgents : SimulatorBehaviour, IAgentSimulation
    {
        [SerializeField, Tooltip("The environment")] private string endpoint = "tcp://127.0.0.1:5560";

        private volatile AgentSimulator simulator;
        private readonly List<string> living = new List<string>();

        /// <inheritdoc/>
        protected override string Endpoint => endpoint;

        /// <inheritdoc/>
        protected override SimulatorBase MakeSimulator() => simulator = new AgentSimulator(this);

        /// <inheritdoc/>
        public abstract string Name { get; }

        /// <inheritdoc/>
        public abstract IReadOnlyList<(string Name, GymSpace Observation, GymSpace Action)> Agents { get; }

        /// <inheritdoc/>
        public virtual InfoQueue Infos { get; } = new InfoQueue();

        /// <inheritdoc/>
        public abstract void ResetWorld(RandomGenerator random, IReadOnlyDictionary<string, object> options);

        /// <summary>Does what the agents want. Physics is simulated after it.</summary>
        protected abstract void Act(IReadOnlyDictionary<string, SpaceReader> actions);

        /// <inheritdoc/>
        public abstract void Observe(string agent, SpaceWriter seen);

        /// <inheritdoc/>
        public abstract (double Reward, bool Terminated, bool Truncated) RewardAndEnd(
            string agent, IDictionary<string, object> info);

        /// <inheritdoc/>
        public virtual void OnInfo(string agent, IReadOnlyDictionary<string, object> info) { }

        /// <summary>Says something to Python, which gets it with the next answer.</summary>
        /// <param name="agent">The agent; empty: the environment.</param>
        /// <param name="info">Texts, numbers, true, false, arrays, lists and dictionaries by name.</param>
        protected void SendInfo(string agent, IReadOnlyDictionary<string, object> info) => Infos.Send(agent, info);

        /// <inheritdoc/>
        public virtual MessageArray Render() => throw new MessageException("no-picture",
            $"{Name} draws none: override Render, or tell check_env skip_render_check=True");

        /// <summary>The action of a person who plays an agent by hand, from Input: its numbers, by default
        /// zeros.</summary>
        protected virtual double[] Heuristic(string agent) => SpaceReader.Nothing(ActionOf(agent));

        /// <inheritdoc/>
        public void Apply(IReadOnlyDictionary<string, SpaceReader> actions)
        {
            Act(actions);
            Physics.Simulate((float)Dt);
        }

        /// <inheritdoc/>
        protected override void FixedUpdate()
        {
            base.FixedUpdate();
            // If Python wants real time the scene moves on while it thinks; else this does nothing.
            simulator?.CatchUp();
        }

        /// <inheritdoc/>
        protected override void ResetByHand(RandomGenerator random)
        {
            ResetWorld(random, new Dictionary<string, object>());
            living.Clear();
            living.AddRange(Agents.Select(agent => agent.Name));
        }

        private GymSpace ActionOf(string agent) => Agents.First(one => one.Name == agent).Action;

        private SpaceReader Played(string agent)
        {
            var action = new SpaceReader(ActionOf(agent));
            action.Set(Heuristic(agent));
            return action;
        }

        /// <inheritdoc/>
        protected override (double Reward, bool Over) StepByHand()
        {
            Apply(living.ToDictionary(agent => agent, Played));
            // Nobody reads them.
            Infos.Take();
            var total = 0.0;
            foreach (var agent in living.ToArray())
            {
                var (reward, terminated, truncated) = RewardAndEnd(agent, new Dictionary<string, object>());
                total += reward;
                if (terminated || truncated) living.Remove(agent);
            }
            return (total, living.Count == 0);
        }
    }
}
