// Lesson 09, the simulator of agents: answers for all of them in one message, and each request once.
//
// Its resets and steps are records (Records.cs), with a row for each agent of a kind. One whose Observation is in C#
// writes its numbers into the answer itself; of the others locators are sent, each with a value. The message info has
// [name or "", info], and render brings the pictures of all agents, or the world's own. In Python: scene/simulator.py.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Linq;

namespace NetMQExample
{
    /// <summary>Answers hello, reset, step, info and render for all agents of a scene; EnvironmentClient brings it to
    /// Python.</summary>
    public sealed class SceneSimulator : SimulatorBase
    {
        // How long a scene may load and its agents may come: Python waits for 10 s as a rule.
        private static readonly TimeSpan MostLoading = TimeSpan.FromSeconds(8);

        private readonly double dt;
        private readonly AgentRoster roster;
        private readonly SceneSteps steps;
        private readonly RealTimeClock real = new RealTimeClock();
        private readonly InfoList infos = new InfoList();
        private readonly SceneRows rows;
        private readonly Stopwatch since = new Stopwatch();
        // An agent judges in its Update: then each step needs a frame.
        private bool framed, frameLeft;
        // Whether it was said that nobody hears what Python sends to the environment, and that a kind idles.
        private bool unheard, idle;
        // A scene was being loaded before this request.
        private bool loadedBefore;
        // Whether the step is done, and only the first observations are left.
        private bool stepped;

        /// <summary>Of the agents and sensors that are in the lists when Python asks: they may come and go. The name is
        /// the env_name in Python, and a tick takes dt seconds.</summary>
        public SceneSimulator(string name, double dt, IReadOnlyList<IAgent> agents, IWorld world = null,
            IReadOnlyList<Source> sensors = null)
        {
            Name = Require.Given("name", name);
            this.dt = dt > 0 ? dt : throw new ArgumentException(FormattableString.Invariant(
                $"dt is seconds, more than 0, not {dt}"));
            foreach (var agent in Require.Given("agents", agents)) Require.Given("agents", agent);
            roster = new AgentRoster(dt, agents, sensors ?? new Source[0])
            { Refuse = (agent, why) => Refuse(agent, why) };
            steps = new SceneSteps(roster, dt) { World = world, Anew = infos.Clear };
            rows = new SceneRows(roster);
        }

        public override string Name { get; }

        /// <summary>By name, how many agents there may be, where these are more than at the hello.</summary>
        public Dictionary<string, int> AtMost => roster.AtMost;

        // Whether a scene is being loaded, such as by an agent's OnReset: its agents come with it.
        internal Func<bool> Loads { get; set; } = () => false;

        /// <summary>Called with each agent for which there is no place, and why.</summary>
        public Action<IAgent, string> Refuse { get; set; } = (agent, why) => { };

        // Why there are no agents.
        internal Func<string> WhyNobody { get; set; } = () => "give it some";

        /// <summary>Called with a line that a person should read.</summary>
        public Action<string> Warn { get; set; } = line => { };

        /// <summary>Hears what Python sends to the environment itself.</summary>
        public event Action<object> OnInfo;

        // Those who hear it in every scene, or null.
        internal Func<Action<object>> Others { get; set; } = () => null;

        // Whether it waits for the agents of a scene that was loaded.
        internal bool Loading { get; private set; }

        internal AgentRoster Roster => roster;
        internal SceneSteps Moves => steps;

        // The scene of those who heard is left.
        internal void ForgetListeners() => OnInfo = null;

        /// <summary>Tells Python something of the environment itself, with the next answer.</summary>
        /// <exception cref="MessageException">It has no place in a message.</exception>
        public void SendInfo(object info) => infos.Send(info);

        /// <summary>The episode is over for every agent.</summary>
        public void Terminate()
        {
            foreach (var row in roster.Rows) if (row.Present) row.State.Terminate();
        }

        /// <summary>The episode is over for every agent, for another reason, such as the time.</summary>
        public void Truncate()
        {
            foreach (var row in roster.Rows) if (row.Present) row.State.Truncate();
        }

        /// <summary>Brings a scene in real time up to the clock; on any other it does nothing.</summary>
        public void CatchUp()
        {
            if (real.On && !Waiting) Inside(() => Steps += CatchUpTo(0));
        }

        public override Message Describe()
        {
            roster.Name();
            if (roster.Rows.Count == 0) throw new MessageException("no-agent", $"{Name} has no agents: {WhyNobody()}");
            real.Switch(false);
            framed = false;
            infos.Clear();
            return Greeting(dt, "python", roster.Kinds.ConvertAll(kind => kind.Describe()));
        }

        public override Message Say(Message request)
        {
            if (request.Kind == "render")
            {
                var picture = new Message("picture", request.Id);
                picture.Arrays.AddRange(rows.Pictures(steps.World?.Render()) ?? throw new MessageException("no-picture",
                    $"{Name} draws none: override Render, or tell check_env skip_render_check=True"));
                return picture;
            }
            if (request.Kind != "info")
                throw new MessageException("unknown-kind",
                    $"kind {MessageWriter.Shown(request.Kind)} is none of reset, step, info, render, close");
            // An info with its receiver, empty for the environment.
            var (to, said) = request.Arrays.Count == 1
                && MessageTree.Read(request.Arrays[0].Data) is List<object> pair
                && pair.Count == 2 && pair[0] is string agent ? (agent, pair[1])
                : throw new MessageException("bad-info", "it is no name with an info");
            Inside(() => (to == "" ? OnInfo + Others() ?? Unheard : Find(to).OnInfo)(said));
            return new Message("told", request.Id);
        }

        public override bool Do(StepRequest request, StepAnswer answer, bool again)
        {
            AgentState.Inside = true;
            try
            {
                if (request.SceneClock)
                    throw new MessageException("wrong-clock",
                        "this simulator goes by Python's clock, and not by the scene's");
                if (!again) Act(request);
                // A frame has passed, for which those without a row have waited.
                else roster.Settle(Loading);
                if (!stepped)
                {
                    if (NeedsFrame()) return false;
                    stepped = true;
                    // A scene that is only kept ready is none to wait for, unless an OnReset wants it.
                    loadedBefore = !Begin(request, answer);
                }
                if (NeedsFrame()) return false;
                See(request, answer);
                return true;
            }
            finally { AgentState.Inside = false; }
        }

        internal IAgent Find(string name) => roster.Find(name);

        internal static void Inside(Action work)
        {
            AgentState.Inside = true;
            try { work(); }
            finally { AgentState.Inside = false; }
        }

        // Checks all of it, and does the step.
        private void Act(StepRequest request)
        {
            since.Restart();
            stepped = Loading = false;
            loadedBefore = Loads();
            roster.Settle(false);
            Steps += CatchUpTo(dt);
            rows.Ask(request, real.On);
            if (!idle && request.Count < roster.Kinds.Count)
            {
                var left = roster.Kinds.Where(kind => !kind.Asked).Select(kind => kind.Name);
                Warn($"nobody asks for {string.Join(", ", left)}: they stand still");
            }
            idle |= request.Count < roster.Kinds.Count;
            LookForLate();
            real.Switch(request.RealTime);
            if (!request.Steps) return;
            Steps += steps.Step(real.On);
            rows.SeeLeaving();
            real.Pass(dt);
            frameLeft = framed;
        }

        // After the step: who has ended is seen a last time, and who is to begin begins. Whether anybody did.
        private bool Begin(StepRequest request, StepAnswer answer)
        {
            roster.Settle(Loading);
            LookForLate();
            Loading = false;
            for (var i = 0; i < request.Count; i++)
                rows.End(roster.Kinds[request[i].Kind], request.Autoreset, answer);
            var again = request.Autoreset
                ? row => row.Order == Order.Reset || row.Ended
                : (Func<AgentRow, bool>)(row => row.Order == Order.Reset);
            var begun = steps.Begin(again, request.Options, request[0].Seed(0));
            Episodes += begun;
            if (begun > 0 && !request.Steps) real.Restart();
            return begun > 0;
        }

        private void See(StepRequest request, StepAnswer answer)
        {
            roster.Settle(Loading);
            // Agents that have come in the frame that has passed.
            Episodes += steps.Begin(row => false, default, 0);
            Loading = roster.Loaded = false;
            for (var i = 0; i < request.Count; i++) rows.See(roster.Kinds[request[i].Kind], answer);
            var said = infos.Take();
            answer.Infos = said == null ? null : MessageTree.Write(said);
        }

        private int CatchUpTo(double but)
        {
            var count = 0;
            while (real.On && roster.Rows.Any(row => row.Lives) && real.IsDue(dt, but)) count += steps.Step(true);
            return count;
        }

        private bool NeedsFrame()
        {
            // The holder of a name may be destroyed at the end of this frame, and another one has come for it.
            var first = frameLeft || roster.Unsettled;
            frameLeft = false;
            if (since.Elapsed > MostLoading) return false;
            var loads = Loads() && !loadedBefore;
            Loading |= loads;
            return first || loads || (Loading && !rows.AreThere());
        }

        private void LookForLate()
        {
            if (framed) return;
            var late = roster.Rows.Find(row => row.Steps && row.State?.Late != null);
            if (late == null) return;
            framed = true;
            Warn($"trouble: agent '{late.Name}' called {late.State.Late} between two steps, such as in its Update: "
                + "from now on each step waits for a frame; in OnAction or OnTick it belongs to its step, at full "
                + "speed");
        }

        private void Unheard(object said)
        {
            if (!unheard)
                Warn("trouble: Python has sent an info to the environment, and nobody hears it: "
                    + "name an agent in send_info, or add a handler to GymEnv.OnInfo");
            unheard = true;
        }
    }
}
