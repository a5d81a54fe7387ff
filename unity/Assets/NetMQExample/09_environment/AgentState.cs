// Lesson 09, an agent's state: what it is told, and what is known of it between two answers to Python.
//
// It needs no UnityEngine. In Python: scene/agent.py.
using System;
using System.Collections.Generic;
using System.Linq;

namespace NetMQExample
{
    /// <summary>The part of an agent that needs no engine.</summary>
    public sealed class AgentState
    {
        // While a simulator resets or steps on this thread.
        [ThreadStatic] internal static bool Inside;
        // How often a script has named an agent.
        [ThreadStatic] internal static int Renames;

        // Names in an info that are the environment's own, or Gymnasium's.
        private static readonly string[] Reserved = { "agent", "env", "lost", "final_obs", "final_info" };

        private readonly InfoList infos = new InfoList();
        private readonly Dictionary<string, object> info = new Dictionary<string, object>();
        private int period;
        private bool terminated, truncated;

        /// <summary>Reads the attributes of an object's class. Several agents of one name get numbers.</summary>
        /// <exception cref="ArgumentException">A locator is wrong; the message names member and column.</exception>
        public AgentState(string name, object observed, int period = 1)
        {
            Period = period;
            Given = Name = Require.Given("name", name);
            Scope = ScopeOf(name);
            foreach (var member in Observed.Members(Require.Given("observed", observed).GetType()))
                Sources.Add(new Source(member.FullName,
                    () => Parse(member.FullName, member.Locator, member.Name, Scope), () => member.Read(observed))
                { Write = (to, last) => member.Write(observed, to, last) });
            var twice = Sources.GroupBy(source => source.Locator.ToString())
                .FirstOrDefault(group => group.Count() > 1 && !group.First().Locator.Mappings.Any(one => one.Appends));
            if (twice != null)
                throw new ArgumentException(
                    $"{string.Join(" and ", twice.Select(source => source.Name))} go to one place: {twice.Key}");
        }

        /// <summary>Its name in Python; decided when Python comes.</summary>
        public string Name { get; private set; }

        /// <summary>How many ticks a step of this agent takes, at least 1.</summary>
        public int Period
        {
            get => period;
            set => period = Math.Max(1, value);
        }

        /// <summary>How many numbers the option "state" has, in which an episode can begin.</summary>
        public int StateSize { get; set; }

        public Locator Scope { get; private set; }

        /// <summary>The members that it sees with, and perhaps others.</summary>
        public List<Source> Sources { get; } = new List<Source>();

        public RandomGenerator Rng { get; private set; } = new RandomGenerator(0);

        public IReadOnlyDictionary<string, object> Options { get; private set; } = new Dictionary<string, object>();

        public double[] FirstState { get; private set; } = new double[0];

        public IDictionary<string, object> Info => info;
        public double Dt => Tick * Period;

        /// <summary>Adds to the reward that goes with the next answer.</summary>
        /// <exception cref="MessageException">It is not finite.</exception>
        public void AddReward(double more) => Change(nameof(AddReward), Reward + Finite(more), terminated, truncated);

        /// <summary>Replaces the reward that goes with the next answer.</summary>
        /// <exception cref="MessageException">It is not finite.</exception>
        public void SetReward(double all) => Change(nameof(SetReward), Finite(all), terminated, truncated);

        public void Terminate() => Change(nameof(Terminate), Reward, true, truncated);
        public void Truncate() => Change(nameof(Truncate), Reward, terminated, true);

        /// <summary>Tells Python something, with the next answer.</summary>
        /// <exception cref="MessageException">It has no place in a message.</exception>
        public void SendInfo(object info) => infos.Send(info);

        // As the scene, or a script, has called it: its number comes with the hello.
        internal string Given { get; private set; }

        internal AgentRow Row { get; set; }
        internal double Tick { get; set; }

        // Since the last answer.
        internal double Reward { get; private set; }

        // It has no more ticks until the next reset.
        internal bool Over => terminated || truncated;

        // The call that came between two steps, such as in an Update, which belongs to neither; or null.
        internal string Late { get; private set; }

        internal void Call(string name, bool given = false)
        {
            if (given)
            {
                (Given, Row) = (name, null);
                Renames++;
            }
            if (name == Name) return;
            Name = name;
            Scope = ScopeOf(name);
            foreach (var source in Sources) source.Place();
        }

        internal void Begin(RandomGenerator random, IReadOnlyDictionary<string, object> options, double[] first)
        {
            Rng = random;
            Options = options;
            FirstState = first;
            Reward = 0;
            terminated = truncated = false;
            infos.Clear();
            info.Clear();
            Late = null;
        }

        // In the same episode there is another one of this name: its scene was loaded anew. In one that has just begun
        // rewards and ends of the one before are of the episode that is over.
        internal void GoOnFrom(AgentState before, bool begun)
        {
            Rng = before.Rng;
            Options = before.Options;
            FirstState = before.FirstState;
            infos.InsertFrom(before.infos);
            foreach (var value in before.info) info.TryAdd(value.Key, value.Value);
            if (begun) return;
            Reward += before.Reward;
            terminated |= before.terminated;
            truncated |= before.truncated;
            Late ??= before.Late;
        }

        // Its reward and ends, which Python gets once. The reward and the ends as marks: 1 terminated, 2 truncated.
        internal (double Reward, byte Ends) Take()
        {
            var taken = Reward;
            Reward = 0;
            Late = null;
            Finite(taken);
            return (taken, (byte)((terminated ? 1 : 0) | (truncated ? 2 : 0)));
        }

        // By name, until TakeInfo is called again; or null.
        internal Dictionary<string, object> TakeInfo()
        {
            if (info.Count > 0) Check();
            var sent = infos.Take();
            if (sent != null) info["agent"] = sent;
            return info.Count > 0 ? info : null;
        }

        internal void ForgetInfo() => info.Clear();

        private void Check()
        {
            foreach (var name in info.Keys)
                if (Array.IndexOf(Reserved, name) >= 0 || name.StartsWith("_", StringComparison.Ordinal)
                    && info.ContainsKey(name.Substring(1)))
                    throw new MessageException("bad-info",
                        $"these names are the environment's own: {MessageWriter.Shown(name)}; {Name} has it");
        }

        private static Locator ScopeOf(string name) => Locator.Parse(LocatorMapping.Quoted(name) + "@");

        internal static Locator Parse(string name, string locator, string standard, Locator scope)
        {
            try { return Locator.Parse(locator, standard, scope); }
            catch (LocatorException e) { throw new ArgumentException($"{name}, locator \"{locator}\": {e.Message}"); }
        }

        private void Change(string what, double reward, bool terminated, bool truncated)
        {
            (Reward, this.terminated, this.truncated) = (reward, terminated, truncated);
            if (!Inside) Late = what;
        }

        private double Finite(double number) => Math.Abs(number) < double.PositiveInfinity
            ? number
            : throw new MessageException("bad-reward",
                FormattableString.Invariant($"the reward of agent '{Name}' is {number}, which is not finite"));
    }

    /// <summary>The infos between two answers: no more than fit, and the others are counted.</summary>
    internal sealed class InfoList
    {
        private const int LimitBytes = 12_000;

        private List<object> infos = new List<object>();
        private int size;
        private long dropped;

        public void Send(object info)
        {
            var one = Observed.Of(info);
            var length = MessageTree.Write(one).Length;
            if (size + length > LimitBytes)
            {
                dropped++;
                return;
            }
            size += length;
            infos.Add(one);
        }

        /// <summary>All of it, or null; and from then on it is empty.</summary>
        public List<object> Take()
        {
            if (dropped > 0) infos.Add(new Dictionary<string, object> { ["dropped"] = dropped });
            if (infos.Count == 0) return null;
            var taken = infos;
            infos = new List<object>();
            size = 0;
            dropped = 0;
            return taken;
        }

        /// <summary>Before its own come those of another one.</summary>
        public void InsertFrom(InfoList before)
        {
            infos.InsertRange(0, before.infos);
            size += before.size;
            dropped += before.dropped;
        }

        public void Clear() => Take();
    }
}
