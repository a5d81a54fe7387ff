// Lesson 09 in Unity: derive from this, and Python decides when time passes in your scene.
//
// Use: start a Python program that makes the environment, add your component to any GameObject, press Play. To play by
// hand, without Python, tick By Hand. How it goes with physics and frames, see SteppedBehaviour.cs.
using System.Collections.Generic;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>A component that steps the environments below it, such as lesson 10's PythonAreas. They, and one on its
    /// own GameObject, do not connect by themselves.</summary>
    public interface IStepsOthers { }

    /// <summary>A scene as a Gymnasium environment: say what can be seen and done, and reset, apply, observe,
    /// reward and end.</summary>
    public abstract class PythonEnvironment : SimulatorBehaviour, ISimulation
    {
        [SerializeField, Tooltip("The environment")] private string endpoint = "tcp://127.0.0.1:5559";

        private SpaceReader played;
        private bool together;

        /// <inheritdoc/>
        public override bool Done => together || base.Done;

        /// <inheritdoc/>
        public override string State => together ? "stepped with others" : base.State;

        /// <inheritdoc/>
        protected override string Endpoint => endpoint;

        /// <inheritdoc/>
        protected override bool Connects => base.Connects && !together;

        /// <inheritdoc/>
        protected override SimulatorBase MakeSimulator() => new Simulator(this);

        /// <inheritdoc/>
        public abstract string Name { get; }

        /// <inheritdoc/>
        public virtual int StateSize => 0;

        /// <inheritdoc/>
        public abstract GymSpace Observation { get; }

        /// <inheritdoc/>
        public abstract GymSpace Action { get; }

        /// <inheritdoc/>
        public abstract void ResetWorld(
            RandomGenerator random, IReadOnlyDictionary<string, object> options, double[] state);

        /// <summary>Does an action. Physics is simulated after it.</summary>
        protected abstract void Act(SpaceReader action);

        /// <inheritdoc/>
        public abstract void Observe(SpaceWriter seen);

        /// <inheritdoc/>
        public abstract (double Reward, bool Terminated, bool Truncated) RewardAndEnd(IDictionary<string, object> info);

        /// <inheritdoc/>
        public virtual MessageArray Render() => throw new MessageException("no-picture",
            $"{Name} draws none: override Render, or tell check_env skip_render_check=True");

        /// <summary>The action of a person who plays by hand, from Input: its numbers, by default zeros.</summary>
        protected virtual double[] Heuristic() => SpaceReader.Nothing(Action);

        /// <inheritdoc/>
        public void Apply(SpaceReader action)
        {
            Act(action);
            if (!together) Physics.Simulate((float)Dt);
        }

        /// <inheritdoc/>
        protected override void Begin()
        {
            together = GetComponentInParent<IStepsOthers>() != null;
            if (!together) base.Begin();
        }

        /// <inheritdoc/>
        protected override void OnDisable()
        {
            if (!together) base.OnDisable();
        }

        /// <inheritdoc/>
        protected override void ResetByHand(RandomGenerator random) =>
            ResetWorld(random, new Dictionary<string, object>(), new double[0]);

        /// <inheritdoc/>
        protected override (double Reward, bool Over) StepByHand()
        {
            played ??= new SpaceReader(Action);
            played.Set(Heuristic());
            Apply(played);
            var (reward, terminated, truncated) = RewardAndEnd(new Dictionary<string, object>());
            return (reward, terminated || truncated);
        }
    }
}
