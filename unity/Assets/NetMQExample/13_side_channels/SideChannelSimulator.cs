// Lesson 13 on lesson 09's steps: one exchange each way in every reset and step, as ML-Agents has it.
//
//     protected override SimulatorBase MakeSimulator() => new SideChannelSimulator(base.MakeSimulator());
//
// So what Python sets before a step is there in that step, and what the scene records in it comes with its state.
// Records.cs says where it stands. The Python side is scene/side_channels.py.
namespace NetMQExample.MLAgents.SideChannels
{
    /// <summary>Around a simulator, whose requests and answers then carry this program's side channels.</summary>
    public sealed class SideChannelSimulator : SimulatorDecorator
    {
        /// <summary>For a simulator, which from then on nobody else asks.</summary>
        public SideChannelSimulator(SimulatorBase simulator) : base(simulator) { }

        public override Message Describe()
        {
            var hello = base.Describe();
            hello.Values["channels"] = true;
            return hello;
        }

        public override bool Do(StepRequest request, StepAnswer answer, bool again)
        {
            if (request.HasExchange && !again) SideChannelManager.Receive(new[] { request.Exchange.ToArray() });
            if (!base.Do(request, answer, again)) return false;
            if (request.HasExchange) answer.Exchange = SideChannelManager.GetSideChannelMessage();
            return true;
        }
    }
}
