// An agent that sees a picture and does nothing else: what is left is the cost of the picture's way to Python.
using System.Linq;

namespace NetMQExample.Lab
{
    /// <summary>Its camera's picture is there already, as CameraView.cs has it from the graphics card.</summary>
    internal sealed class Seeing : PlainAgent
    {
        private readonly MessageArray picture;

        private Seeing(int width, int height)
        {
            Observation = GymSpace.Picture(height, width);
            picture = new MessageArray("uint8", new byte[height * width * 3], height, width, 3);
        }

        public override GymSpace Observation { get; }
        public override GymSpace Action { get; } = GymSpace.Discrete(2);
        public override void Observe(SpaceWriter seen) => seen.Add(picture);

        /// <summary>Takes steps until the environment closes it.</summary>
        public static void Run(string endpoint, int width, int height, int count)
        {
            var agents = Enumerable.Range(0, count).Select(_ => new Seeing(width, height)).ToArray();
            using var client = new EnvironmentClient(endpoint);
            client.Run(new SceneSimulator("Seeing", 0.02, agents), 0, answer => answer());
        }
    }
}
