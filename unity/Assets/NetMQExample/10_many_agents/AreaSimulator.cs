// Lesson 10, areas: many copies of one simulation, and one message steps them all.
//
// A record (Records.cs) has a row for each area, and says of each whether it steps or resets, so Python alone
// decides that. The Python side is python/netmq_example/envs/vector_env.py.
// Trouble: start it with another number of areas than num_envs.
using System.Collections.Generic;
using System.Linq;

namespace NetMQExample
{
    /// <summary>Answers reset, step and render for all areas at once.</summary>
    public sealed class AreaSimulator : Simulator
    {
        /// <summary>For simulations of one kind, at least one, which from then on nobody else steps.</summary>
        public AreaSimulator(IEnumerable<ISimulation> areas) : base(Require.Given("areas", areas).ToArray()) { }

        /// <inheritdoc/>
        public override Message Describe()
        {
            var hello = base.Describe();
            hello.Values["areas"] = (long)Count;
            return hello;
        }
    }
}
