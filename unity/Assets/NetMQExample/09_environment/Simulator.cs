// Lesson 09, the simulator: does in a simulation what an environment asks for, and each request once.
using System;
using System.Collections.Generic;
using System.Linq;

namespace NetMQExample
{
    /// <summary>Answers requests. The last answer is kept, and a request that comes again gets it again: so a retry
    /// never steps twice.</summary>
    public abstract class SimulatorBase
    {
        private Message kept;

        /// <summary>Called with each mistake in the simulation. Python hears of it as well, in one line.</summary>
        public Action<Exception> Mistake { get; set; } = e => Console.Error.WriteLine(e);

        /// <summary>How many episodes were begun.</summary>
        public int Episodes { get; protected set; }

        /// <summary>How many steps were done.</summary>
        public int Steps { get; protected set; }

        /// <summary>What it simulates.</summary>
        public abstract string Name { get; }

        /// <summary>What an environment has to know. Its requests are counted anew.</summary>
        public Message Hello() => kept = Describe();

        /// <summary>The answer to a new id, or what was answered last.</summary>
        /// <param name="request">Of any kind but close.</param>
        /// <returns>Of kind error if the request cannot be answered.</returns>
        public Message Answer(Message request)
        {
            if (request.Id <= kept.Id) return kept;
            try
            {
                kept = Do(request);
                // What cannot be written, such as a reward that is no number, is found out here.
                kept.Header();
            }
            catch (MessageException e)
            {
                kept = Refusal(request, e.Code, e.Message.Substring(e.Code.Length + 2));
            }
            catch (Exception e)
            {
                // A mistake in the simulation must not end it: its place is for whoever writes it.
                Mistake(e);
                kept = Refusal(request, "error-in-simulation", $"{e.GetType().Name}: {e.Message.Split('\n')[0]}");
            }
            return kept;
        }

        private static Message Refusal(Message request, string code, string text) =>
            new Message("error", request.Id) { Values = { ["code"] = code, ["text"] = text } };

        /// <summary>A hello: name, dt and spaces.</summary>
        protected abstract Message Describe();

        /// <summary>Does what is asked for, and answers it.</summary>
        protected abstract Message Do(Message request);
    }

    /// <summary>Answers reset, step and render for one simulation. Lesson 17 derives from it.</summary>
    public class Simulator : SimulatorBase
    {
        private readonly ISimulation simulation;

        /// <summary>For a simulation, which from then on nobody else steps.</summary>
        public Simulator(ISimulation simulation) => this.simulation = Require.Given("simulation", simulation);

        /// <inheritdoc/>
        public override string Name => simulation.Name;

        /// <inheritdoc/>
        protected override Message Describe()
        {
            var hello = new Message("hello");
            var see = simulation.Observation;
            var act = simulation.Action;
            hello.Values["name"] = simulation.Name;
            hello.Values["dt"] = simulation.Dt;
            hello.Values["observation"] = see.Kind;
            hello.Values["action"] = act.Kind;
            hello.Arrays.AddRange(see.Arrays.Concat(act.Arrays));
            return hello;
        }

        /// <inheritdoc/>
        protected override Message Do(Message request)
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
                    state.Values["terminated"] = terminated;
                    state.Values["truncated"] = truncated;
                    break;
                case "render":
                    state.Arrays.Add(simulation.Render());
                    return state;
                default:
                    throw new MessageException("unknown-kind",
                        $"kind {MessageJson.Shown(request.Kind)} is none of reset, step, render, close");
            }
            state.Arrays.Add(simulation.Observe() ?? throw new InvalidOperationException("Observe gave null"));
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
