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
        private readonly StepAnswer state = new StepAnswer();
        private long id;

        /// <summary>Called with each mistake in the simulation. Python hears of it as well, in one line.</summary>
        public Action<Exception> Mistake { get; set; } = e => Console.Error.WriteLine(e);

        /// <summary>How many episodes were begun.</summary>
        public int Episodes { get; protected set; }

        /// <summary>How many steps were done.</summary>
        public int Steps { get; protected set; }

        /// <summary>The simulated world.</summary>
        public abstract string Name { get; }

        /// <summary>The last answer, where it was in words; else null, and it is in <see cref="Frame"/>.</summary>
        public Message Reply { get; private set; }

        /// <summary>The last answer to a reset or a step.</summary>
        public ReadOnlyMemory<byte> Frame { get; private set; }

        /// <summary>Whether a frame must pass before what was asked for can be answered: Answer it again then.
        /// </summary>
        public bool Waiting { get; private set; }

        /// <summary>The hello, which tells an environment the spaces. Ids of requests start again.</summary>
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
                if (!Waiting)
                {
                    id = request.Id;
                    state.Begin(request);
                    Do(request, state);
                }
                Waiting = NeedsFrame();
                if (Waiting) return;
                See(request, state);
                Frame = state.Frame();
                Reply = null;
            }
            catch (Exception e)
            {
                Waiting = false;
                Reply = Refusal(e);
            }
        }

        /// <summary>Answers what was asked in words, unless that was done before. The answer is kept.</summary>
        /// <param name="request">Of any kind but close.</param>
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
            catch (Exception e)
            {
                Reply = Refusal(e);
            }
        }

        /// <summary>A hello: name, dt and spaces.</summary>
        public abstract Message Describe();

        /// <summary>Resets or steps, and says what is seen then, unless See does.</summary>
        public abstract void Do(StepRequest request, StepAnswer answer);

        /// <summary>Whether a frame must pass between Do and See. It is asked after Do, and again after each frame.
        /// </summary>
        public virtual bool NeedsFrame() => false;

        /// <summary>Says what is seen, after what was done.</summary>
        public virtual void See(StepRequest request, StepAnswer answer) { }

        /// <summary>Answers what is asked in words, such as render.</summary>
        public abstract Message Say(Message request);

        /// <summary>A hello, whose one array describes the spaces.</summary>
        protected static Message HelloOf(string name, double dt, Dictionary<string, object> spaces)
        {
            var data = MessageTree.Write(spaces);
            return new Message("hello")
            {
                Values = { ["name"] = name, ["dt"] = dt },
                Arrays = { new MessageArray("uint8", data, data.Length) },
            };
        }

        /// <summary>An info with its receiver, empty for the environment.</summary>
        protected static (string Whom, object Info) InfoOf(Message request) => request.Arrays.Count == 1
            && MessageTree.Read(request.Arrays[0].Data) is List<object> pair
            && pair.Count == 2 && pair[0] is string agent ? (agent, pair[1])
            : throw new MessageException("bad-info", "it is no name with an info");

        /// <summary>To throw: the request is unknown.</summary>
        protected static MessageException Unknown(Message request, string known) => new MessageException("unknown-kind",
            $"kind {MessageJson.Shown(request.Kind)} is none of reset, step, {known}, close");

        private Message Refusal(Exception e)
        {
            if (e is MessageException known)
                return Error(known.Code, known.Message.Substring(known.Code.Length + 2));
            // A mistake in the simulation must not end it: its place is for whoever writes it.
            Mistake(e);
            var text = LogText.Printable((e.Message ?? "").Split('\n')[0]);
            return Error("error-in-simulation", $"{e.GetType().Name}: {text}");
        }

        private Message Error(string code, string text) =>
            new Message("error", id) { Values = { ["code"] = code, ["text"] = text } };
    }

    /// <summary>Answers reset, step and render for one simulation, or for many areas of one kind.</summary>
    public class Simulator : SimulatorBase
    {
        private readonly ISimulation[] areas;
        private readonly SpaceReader[] actions;
        private readonly SpaceWriter seen;
        // For a person who must mend something. Made when they are needed: in Unity on the main thread.
        private string[] names;
        private readonly Dictionary<string, object> info = new Dictionary<string, object>();

        /// <summary>For simulations of one kind, which from then on nobody else steps.</summary>
        public Simulator(params ISimulation[] areas)
        {
            this.areas = Require.Given("areas", areas);
            if (areas.Length == 0) throw new ArgumentException("areas takes at least one simulation");
            foreach (var area in areas) Require.Given("areas", area);
            var action = areas[0].Action;
            actions = Array.ConvertAll(areas, area => new SpaceReader(action));
            seen = new SpaceWriter(areas[0].Observation);
        }

        /// <summary>Called when all that step have done their actions, and before any begins anew: in Unity physics
        /// moves then.</summary>
        public Action Moved { get; set; } = () => { };

        /// <inheritdoc/>
        public override string Name => areas[0].Name;

        /// <summary>How many areas there are.</summary>
        protected int Count => areas.Length;

        /// <inheritdoc/>
        public override Message Describe() => HelloOf(Name, areas[0].Dt, new Dictionary<string, object>
        {
            ["observation"] = areas[0].Observation.Description,
            ["action"] = areas[0].Action.Description,
        });

        /// <inheritdoc/>
        public override Message Say(Message request)
        {
            if (request.Kind != "render") throw Unknown(request, "render");
            var picture = new Message("picture", request.Id);
            picture.Arrays.AddRange(areas.Select(area => area.Render()));
            return picture;
        }

        /// <inheritdoc/>
        public override void Do(StepRequest request, StepAnswer answer)
        {
            if (request.Count != areas.Length)
                throw new MessageException("wrong-areas", $"this simulator has {areas.Length} areas, not "
                    + $"{request.Count}: make_vec(…, num_envs={areas.Length}), and a name that is registered with "
                    + "vector_entry_point");
            // All actions are looked at before the first area moves: half a step would be none.
            for (var i = 0; i < areas.Length; i++)
                if (request.OrderOf(i) == Order.Step) actions[i].Read(request.Row(i));
            var resets = request.Has(Order.Reset);
            var options = resets ? request.ReadOptions() : null;
            var state = resets ? State(options) : null;
            for (var i = 0; i < areas.Length; i++)
            {
                if (request.OrderOf(i) != Order.Step) continue;
                areas[i].Apply(actions[i]);
                Steps++;
            }
            if (request.Has(Order.Step)) Moved();
            for (var i = 0; i < areas.Length; i++)
            {
                if (request.OrderOf(i) != Order.Reset) continue;
                areas[i].ResetWorld(new RandomGenerator(request.Seed(i)), options, state);
                Episodes++;
            }
            for (var i = 0; i < areas.Length; i++) SeeArea(i, request.OrderOf(i), answer);
        }

        private void SeeArea(int i, Order order, StepAnswer answer)
        {
            info.Clear();
            var verdict = order == Order.Step ? areas[i].RewardAndEnd(info) : (0, false, false);
            areas[i].Observe(seen.Begin(answer.Rows));
            seen.End();
            names ??= areas.Select((area, at) => Count > 1 ? $"{area.Name}, area {at}" : area.Name).ToArray();
            answer.EndRow(names[i], verdict, info);
        }

        private double[] State(Dictionary<string, object> options)
        {
            if (!options.Remove("state", out var given)) return new double[0];
            var array = given as MessageArray;
            var list = given as List<object>;
            // Counted before they are converted: a message may have millions.
            var length = array != null ? array.Data.Length / MessageArray.SizeOf(array.Dtype) : list?.Count ?? 0;
            if (length != 0 && length != areas[0].StateSize)
                throw new MessageException("bad-state", $"a state is {areas[0].StateSize} numbers, not {length}");
            return array != null ? SpaceNumbers.Of(array)
                : list != null && list.All(one => one is long || one is double)
                    ? list.Select(Convert.ToDouble).ToArray()
                : throw new MessageException("bad-state", "a state is numbers");
        }
    }
}
