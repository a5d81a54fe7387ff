// Lesson 09, the simulator: does in a simulation what an environment asks for, and each request once.
using System;
using System.Collections.Generic;

namespace NetMQExample
{
    /// <summary>Answers requests. The last answer is kept, and a request that comes again gets it again: so a retry
    /// never steps twice.</summary>
    public abstract class SimulatorBase
    {
        private readonly StepAnswer answer = new StepAnswer();
        private long id;

        /// <summary>Called with each mistake in the simulation. Python hears of it as well, in one line.</summary>
        public Action<Exception> Mistake { get; set; } = e => Console.Error.WriteLine(e);

        public int Episodes { get; protected set; }
        public int Steps { get; protected set; }
        public abstract string Name { get; }

        /// <summary>The last answer, where it was in words; else null, and it is in <see cref="Frame"/>.</summary>
        public Message Reply { get; private set; }

        /// <summary>The last answer to a reset or a step.</summary>
        public ReadOnlyMemory<byte> Frame { get; private set; }

        /// <summary>Whether a frame must pass before the request can be answered: Answer it again then.</summary>
        public bool Waiting { get; private set; }

        /// <summary>The hello, which tells an environment who is there. Ids of requests start again.</summary>
        public Message Hello()
        {
            id = 0;
            Waiting = false;
            return Reply = Describe();
        }

        /// <summary>Answers a reset or a step, unless that was done before. The answer is kept.</summary>
        public void Answer(StepRequest request)
        {
            if (request.Id <= id && !Waiting) return;
            try
            {
                var again = Waiting;
                id = request.Id;
                if (!again) answer.Begin(request.Id);
                Waiting = !Do(request, answer, again);
                if (Waiting) return;
                Frame = answer.Frame();
                Reply = null;
            }
            catch (Exception e)
            {
                Waiting = false;
                Reply = Refusal(e);
            }
        }

        /// <summary>The same for what is asked in words, of any kind but close.</summary>
        public void Answer(Message request)
        {
            if (request.Id <= id) return;
            id = request.Id;
            try
            {
                Reply = Say(request);
                // A value that cannot be written is found here.
                Reply.Header();
            }
            catch (Exception e) { Reply = Refusal(e); }
        }

        /// <summary>A hello: name, dt and the kinds of agents.</summary>
        public abstract Message Describe();

        /// <summary>Resets or steps, and says what is seen then.</summary>
        /// <param name="again">False at first; true when a frame has passed for it.</param>
        /// <returns>Whether it is done; else a frame must pass, and then it is called again.</returns>
        public abstract bool Do(StepRequest request, StepAnswer answer, bool again);

        /// <summary>Answers what is asked in words, such as render.</summary>
        public abstract Message Say(Message request);

        // Of a simulator by Python's clock, or by the scene's.
        internal Message Greeting(double dt, string clock, List<object> kinds)
        {
            var data = MessageTree.Write(new Dictionary<string, object> { ["kinds"] = kinds });
            return new Message("hello")
            {
                Values =
                {
                    ["name"] = Name, ["dt"] = dt, ["record"] = 2L, ["clock"] = clock, ["channels"] = clock == "scene",
                },
                Arrays = { new MessageArray("uint8", data, data.Length) },
            };
        }

        private Message Refusal(Exception e)
        {
            if (e is MessageException known) return Error(known.Code, known.Text);
            // A mistake in the simulation must not end it: its place is for whoever writes it.
            Mistake(e);
            var text = LogText.Printable((e.Message ?? "").Split('\n')[0]);
            return Error("error-in-simulation", $"{e.GetType().Name}: {text}");
        }

        private Message Error(string code, string text) =>
            new Message("error", id) { Values = { ["code"] = code, ["text"] = text } };
    }

    /// <summary>Passes everything on to a simulator, which from then on nobody else asks. Lessons 13 and 17 override
    /// what they add.</summary>
    public abstract class SimulatorDecorator : SimulatorBase
    {
        private readonly SimulatorBase simulator;

        protected SimulatorDecorator(SimulatorBase simulator) => this.simulator = Require.Given("simulator", simulator);

        public override string Name => simulator.Name;

        public override Message Describe() => simulator.Describe();
        public override Message Say(Message request) => simulator.Say(request);

        public override bool Do(StepRequest request, StepAnswer answer, bool again)
        {
            var done = simulator.Do(request, answer, again);
            Episodes = simulator.Episodes;
            Steps = simulator.Steps;
            return done;
        }
    }
}
