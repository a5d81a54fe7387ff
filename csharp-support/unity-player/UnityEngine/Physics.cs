// Physics as far as a script steps it itself: nothing moves by it, but what Unity would refuse is refused.
namespace UnityEngine
{
    public enum SimulationMode
    {
        FixedUpdate,
        Update,
        Script,
    }

    // Nothing here has one.
    public class Collider : Component
    {
    }

    public class Physics
    {
        private static SimulationMode mode;

        public static SimulationMode simulationMode
        {
            get { MainThread.Only("get_simulationMode"); return mode; }
            set { MainThread.Only("set_simulationMode"); mode = value; }
        }

        public static void Simulate(float step)
        {
            MainThread.Only(nameof(Simulate));
            if (mode != SimulationMode.Script)
                Debug.LogWarning("Physics.Simulate does nothing while the simulation mode is another than Script");
        }
    }
}
