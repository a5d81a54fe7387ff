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

        /// <summary>What is seen.</summary>
        GymSpace Observation { get; }

        /// <summary>What can be done.</summary>
        GymSpace Action { get; }

        /// <summary>Begins an episode.</summary>
        /// <param name="chance">Where all that is random comes from.</param>
        /// <param name="options">What Python gave to reset: texts, numbers, true and false.</param>
        /// <param name="state">Where to begin, <see cref="StateSize"/> numbers; empty: by chance.</param>
        void ResetWorld(Chance chance, IReadOnlyDictionary<string, object> options, double[] state);

        /// <summary>Does it, for <see cref="Dt"/> seconds.</summary>
        /// <param name="action">In <see cref="Action"/>; of a discrete one its number.</param>
        void Apply(double[] action);

        /// <summary>What is seen now, such as <c>Observation.Of(x, y)</c>.</summary>
        MessageArray Observe();

        /// <summary>How good that was, and whether the episode is over.</summary>
        /// <param name="info">Takes whatever else Python is to know: texts, numbers, true and false.</param>
        (double Reward, bool Terminated, bool Truncated) Judge(IDictionary<string, object> info);

        /// <summary>A picture, uint8 [height, width, 3], the highest row first.</summary>
        MessageArray Render();
    }
}
