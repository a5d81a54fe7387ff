// Lesson 10 in Unity: derive from this, and one message steps many copies of a world in your scene.
//
// Use: public sealed class MyAreas : PythonAreas<MyEnvironment> { }, where MyEnvironment is your PythonEnvironment of
// lesson 09. Make a prefab of one area with it, put as many as you like below one GameObject, far enough apart for
// physics, and add MyAreas to that. In Python register its name with
// vector_entry_point="netmq_example.envs:ZmqVectorEnv", as the guide's page for this lesson shows, and call
// make_vec("My/NAME-v0", num_envs=16).
using System.Linq;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>A scene with many areas as a vector environment. The areas below it do not connect by
    /// themselves; one on its own GameObject does nothing.</summary>
    /// <typeparam name="TArea">The environment of each area.</typeparam>
    public abstract class PythonAreas<TArea> : SteppedBehaviour, IStepsOthers where TArea : PythonEnvironment
    {
        [SerializeField, Tooltip("The environment")] private string endpoint = "tcp://127.0.0.1:5560";

        private TArea[] areas;

        /// <inheritdoc/>
        protected override string Endpoint => endpoint;

        /// <inheritdoc/>
        protected override bool Connects => areas.Length > 0;

        /// <inheritdoc/>
        protected override void Begin()
        {
            areas = GetComponentsInChildren<TArea>().Where(area => area.gameObject != gameObject).ToArray();
            if (!Connects) GiveUp($"{name} has no {typeof(TArea).Name} below it; put one into each area");
            base.Begin();
        }

        /// <inheritdoc/>
        protected override SimulatorBase MakeSimulator() =>
            new AreaSimulator(areas) { Moved = () => Physics.Simulate((float)areas[0].Dt) };
    }
}
