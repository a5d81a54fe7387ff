// Lesson 09, the simulator: does in a simulation what an environment asks for, and each request once.
//
// Take home: this file, Simulation.cs and GymSpace.cs, with Message.cs and MessageJson.cs (lesson 05).
using System;
using System.Collections.Generic;
using System.Linq;

namespace NetMQExample
{
    /// <summary>Answers reset, step and render. The last answer is kept, and a request that comes again gets it again:
    /// so a retry never steps twice.</summary>
    public class Simulator
    {
        private readonly ISimulation simulation;
        private Message kept;

        /// <summary>For a simulation, which from then on nobody else steps.</summary>
        public Simulator(ISimulation simulation) : this(simulation.Name) => this.simulation = simulation;

        /// <summary>For one that derives from this, and knows itself how to describe and do.</summary>
        protected Simulator(string name) => Name = name;

        /// <summary>How many episodes were begun.</summary>
        public int Episodes { get; protected set; }

        /// <summary>How many steps were done.</summary>
        public int Steps { get; protected set; }

        /// <summary>What it simulates.</summary>
        public string Name { get; }

        /// <summary>What an environment has to know. Its requests are counted anew.</summary>
        public Message Hello() => kept = Describe();

        /// <summary>The hello.</summary>
        protected virtual Message Describe()
        {
            var (hello, see, act) = (new Message("hello"), simulation.Observation, simulation.Action);
            (hello.Values["name"], hello.Values["dt"]) = (simulation.Name, simulation.Dt);
            (hello.Values["observation"], hello.Values["action"]) = (see.Kind, act.Kind);
            hello.Arrays.AddRange(see.Arrays.Concat(act.Arrays));
            return hello;
        }

        /// <summary>What this id got already, or the answer to a new one.</summary>
        /// <param name="request">Of kind reset, step or render.</param>
        /// <returns>Of kind state or picture; of kind error if the request cannot be answered.</returns>
        public Message Answer(Message request)
        {
            if (request.Id == kept.Id) return kept;
            try
            {
                kept = Do(request);
                // What cannot be written, such as a reward that is no number, is found out here.
                kept.Header();
            }
            catch (Exception e)
            {
                // A mistake in the simulation must not end it: Python is told, and what it was.
                var (code, text) = e is MessageException refusal
                    ? (refusal.Code, refusal.Message.Substring(refusal.Code.Length + 2))
                    : ("error-in-simulation", e.ToString());
                kept = new Message("error", request.Id) { Values = { ["code"] = code, ["text"] = text } };
            }
            return kept;
        }

        /// <summary>The answer to a request that has not come before.</summary>
        protected virtual Message Do(Message request)
        {
            var state = new Message(request.Kind == "render" ? "picture" : "state", request.Id);
            switch (request.Kind)
            {
                case "reset":
                    Reset(request);
                    break;
                case "step":
                    simulation.Apply(simulation.Action.Read(request.Arrays));
                    Steps++;
                    var (reward, terminated, truncated) = simulation.Judge(state.Values);
                    state.Values["reward"] = reward;
                    (state.Values["terminated"], state.Values["truncated"]) = (terminated, truncated);
                    break;
                case "render":
                    state.Arrays.Add(simulation.Render());
                    return state;
                default:
                    throw new MessageException("unknown-kind",
                        $"kind {MessageJson.Shown(request.Kind)} is none of reset, step, render, close");
            }
            state.Arrays.Add(simulation.Observe());
            return state;
        }

        private void Reset(Message request)
        {
            if (!(request.Values.GetValueOrDefault("seed") is long seed))
                throw new MessageException("missing-field", "reset needs a whole number 'seed'");
            var state = request.Arrays.SelectMany(GymSpace.Numbers).ToArray();
            if (state.Length != 0 && state.Length != simulation.StateSize)
                throw new MessageException("bad-state",
                    $"a state is {simulation.StateSize} numbers, not {state.Length}");
            simulation.ResetWorld(new Chance(seed), request.Values, state);
            Episodes++;
        }
    }
}
