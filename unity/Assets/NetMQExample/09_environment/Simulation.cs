// Lesson 09, a simulation: what a world needs, so that an environment can be made of it. In Python: simulation.py.
using System.Collections.Generic;

namespace NetMQExample
{
    /// <summary>Your own world has these. In Unity derive from PythonEnvironment, which is one.</summary>
    public interface ISimulation
    {
        /// <summary>The name in NetMQExample/NAME-v0.</summary>
        string Name { get; }

        /// <summary>How many seconds one step takes.</summary>
        double Dt { get; }

        /// <summary>How many numbers its state has.</summary>
        int StateSize { get; }

        /// <summary>The space of the observation.</summary>
        GymSpace Observation { get; }

        /// <summary>The space of the action.</summary>
        GymSpace Action { get; }

        /// <summary>Begins an episode.</summary>
        /// <param name="random">Where all that is random comes from.</param>
        /// <param name="options">The options that Python gave to reset, by name.</param>
        /// <param name="state">Where to begin, <see cref="StateSize"/> numbers; empty: by chance.</param>
        void ResetWorld(RandomGenerator random, IReadOnlyDictionary<string, object> options, double[] state);

        /// <summary>Does it, for <see cref="Dt"/> seconds.</summary>
        /// <param name="action">In <see cref="Action"/>: <c>action[0]</c> is its first number. The next action
        /// comes in the same object, so copy the numbers that you keep.</param>
        void Apply(SpaceReader action);

        /// <summary>Says what is seen now, such as <c>seen.Add(x, y)</c>.</summary>
        void Observe(SpaceWriter seen);

        /// <summary>How good that was, and whether the episode is over.</summary>
        /// <param name="info">Takes whatever else Python is to know, by name.</param>
        (double Reward, bool Terminated, bool Truncated) RewardAndEnd(IDictionary<string, object> info);

        /// <summary>A picture, uint8 [height, width, 3], the highest row first.</summary>
        MessageArray Render();
    }
}
