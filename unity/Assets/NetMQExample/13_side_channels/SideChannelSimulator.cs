// Lesson 13 on lesson 09's steps: one exchange each way in every reset and step, as ML-Agents has it.
//
//     protected override SimulatorBase MakeSimulator() => new SideChannelSimulator(base.MakeSimulator());
//
// So what Python sets before a step is there in that step, and what the scene records in it comes with its state.
// Bytes: lesson 09's, with the value side_channel, true, and the exchange as one more array, the last one, uint8. The
// Python side is simulation/side_channels.py.
namespace NetMQExample.SideChannels
{
    /// <summary>Around a simulator, whose requests and answers then carry this program's side channels.</summary>
    public sealed class SideChannelSimulator : SimulatorBase
    {
        private readonly SimulatorBase simulator;

        /// <summary>For a simulator, which from then on nobody else asks.</summary>
        public SideChannelSimulator(SimulatorBase simulator) => this.simulator = Require.Given("simulator", simulator);

        /// <inheritdoc/>
        public override string Name => simulator.Name;

        /// <inheritdoc/>
        protected override Message Describe() => simulator.Hello();

        /// <inheritdoc/>
        protected override Message Do(Message request)
        {
            var carried = request.Values.Remove("side_channel") && request.Arrays.Count > 0;
            if (carried)
            {
                var last = request.Arrays.Count - 1;
                SideChannelManager.Receive(new[] { request.Arrays[last].Data.ToArray() });
                request.Arrays.RemoveAt(last);
            }
            simulator.Mistake = Mistake;
            var answer = simulator.Answer(request);
            Episodes = simulator.Episodes;
            Steps = simulator.Steps;
            if (!carried || answer.Kind == "error") return answer;
            var data = SideChannelManager.GetSideChannelMessage();
            answer.Values["side_channel"] = true;
            answer.Arrays.Add(new MessageArray("uint8", data, data.Length));
            return answer;
        }
    }
}
