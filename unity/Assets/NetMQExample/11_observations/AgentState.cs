// Lesson 11, an agent: what it is told, and what is known of it between two answers to Python.
//
// It needs no UnityEngine: the component is Agent.cs. In Python: netmq_example/scene/scene.py.
using System;
using System.Collections.Generic;
using System.Linq;

namespace NetMQExample
{
    /// <summary>Somebody who sees and acts.</summary>
    public interface IAgent
    {
        /// <summary>Its name, its rewards and what it sees.</summary>
        AgentState State { get; }

        /// <summary>An episode begins.</summary>
        void OnReset();

        /// <summary>Python's action: long, double, bool, string, MessageArray, List&lt;object&gt;,
        /// Dictionary&lt;string, object&gt;, or GraphInstance.</summary>
        void OnAction(object action);

        /// <summary>One step of the world's time; none more once its episode is over.</summary>
        /// <param name="dt">Seconds.</param>
        void OnTick(double dt);

        /// <summary>Python's send_info, of the same types as an action.</summary>
        void OnInfo(object info);
    }

    /// <summary>One place where a value comes from, and where it goes.</summary>
    public sealed class Source
    {
        /// <summary>With its locator already put where it belongs.</summary>
        public Source(string name, Locator locator, Func<object> read)
        {
            Name = Require.Given("name", name);
            Locator = Require.Given("locator", locator);
            Read = Require.Given("read", read);
            Text = locator.ToString();
        }

        /// <summary>Its locator's canonical text.</summary>
        public string Text { get; }

        /// <summary>Whether its value goes into the observation of this agent, perhaps among others.</summary>
        public bool Names(string agent)
        {
            foreach (var mapping in Locator.Mappings) if (mapping.Names(agent)) return true;
            return false;
        }

        /// <summary>For a person who must mend something.</summary>
        public string Name { get; }

        /// <summary>Where it goes; it names agents.</summary>
        public Locator Locator { get; }

        /// <summary>Its value now.</summary>
        public Func<object> Read { get; }
    }

    /// <summary>The part of an agent that needs no engine.</summary>
    public sealed class AgentState
    {
        // While a simulator resets or steps on this thread.
        [ThreadStatic] internal static bool Inside;

        private readonly List<object> infos = new List<object>();
        private double reward;
        private int period;
        private bool terminated, truncated;

        /// <summary>Reads the attributes of an object's class.</summary>
        /// <param name="name">The agent's; two agents of a scene have two.</param>
        /// <param name="observed">The object with the observed members.</param>
        /// <param name="period">How many ticks a step of this agent takes.</param>
        /// <exception cref="ArgumentException">A locator is wrong; the message names member and column.</exception>
        public AgentState(string name, object observed, int period = 1)
        {
            Name = Require.Given("name", name);
            Period = period;
            Scope = Locator.Parse(LocatorMapping.Quoted(name) + "@");
            foreach (var member in Observed.Members(Require.Given("observed", observed).GetType()))
                Sources.Add(Make(member.FullName, member.Locator, member.Name, Scope, () => member.Read(observed)));
            var twice = Sources.GroupBy(source => source.Text)
                .FirstOrDefault(group => group.Count() > 1 && !group.First().Locator.Mappings.Any(one => one.Appends));
            if (twice != null)
                throw new ArgumentException(
                    $"{string.Join(" and ", twice.Select(source => source.Name))} go to one place: {twice.Key}");
        }

        /// <summary>Its name in Python.</summary>
        public string Name { get; }

        /// <summary>How many ticks a step of this agent takes, at least 1.</summary>
        public int Period
        {
            get => period;
            set => period = Math.Max(1, value);
        }

        /// <summary>Where its relative locators begin.</summary>
        public Locator Scope { get; }

        /// <summary>The members and sensors that it sees with.</summary>
        public List<Source> Sources { get; } = new List<Source>();

        /// <summary>The random numbers of this episode, which Python's seed decides.</summary>
        public RandomGenerator RandomGenerator { get; private set; } = new RandomGenerator(0);

        /// <summary>The options that Python gave to reset.</summary>
        public IReadOnlyDictionary<string, object> Options { get; private set; } = new Dictionary<string, object>();

        /// <summary>A source whose locator is read here, once.</summary>
        /// <exception cref="ArgumentException">The locator is wrong; the message says where.</exception>
        public static Source Make(string name, string locator, string standard, Locator scope, Func<object> read)
        {
            try { return new Source(name, Locator.Parse(locator, standard, scope), read); }
            catch (LocatorException e) { throw new ArgumentException($"{name}, locator \"{locator}\": {e.Message}"); }
        }

        /// <summary>Adds to the reward that goes with the next answer.</summary>
        /// <exception cref="MessageException">It is not finite.</exception>
        public void AddReward(double more) => Change(nameof(AddReward), reward + Finite(more), terminated, truncated);

        /// <summary>Replaces the reward that goes with the next answer.</summary>
        /// <exception cref="MessageException">It is not finite.</exception>
        public void SetReward(double all) => Change(nameof(SetReward), Finite(all), terminated, truncated);

        /// <summary>The episode is over for it: it has reached an end of the world.</summary>
        public void Terminate() => Change(nameof(Terminate), reward, true, truncated);

        /// <summary>The episode is over for it, for another reason, such as the time.</summary>
        public void Truncate() => Change(nameof(Truncate), reward, terminated, true);

        /// <summary>Tells Python something, with the next answer.</summary>
        /// <exception cref="MessageException">It has no place in a message.</exception>
        public void SendInfo(object info) => infos.Add(Observed.Of(info));

        // Since the last answer.
        internal double Reward => reward;

        // It has no more ticks until the next reset.
        internal bool Over => terminated || truncated;

        // The call that came between two steps, such as in an Update, which belongs to neither; or null.
        internal string Late { get; private set; }

        internal void Begin(RandomGenerator random, IReadOnlyDictionary<string, object> options)
        {
            RandomGenerator = random;
            Options = options;
            reward = 0;
            terminated = false;
            truncated = false;
            infos.Clear();
            Late = null;
        }

        // In the same episode there is another one of this name: its scene was loaded anew. In one that has just begun
        // rewards and ends of the one before are of the episode that is over.
        internal void GoOnFrom(AgentState before, bool begun)
        {
            RandomGenerator = before.RandomGenerator;
            Options = before.Options;
            infos.InsertRange(0, before.infos);
            if (begun) return;
            reward += before.reward;
            terminated |= before.terminated;
            truncated |= before.truncated;
            Late ??= before.Late;
        }

        // Python gets each info once.
        internal (double Reward, bool Terminated, bool Truncated) Take(Dictionary<string, object> info)
        {
            if (infos.Count > 0) info["agent"] = new List<object>(infos);
            infos.Clear();
            var taken = reward;
            reward = 0;
            Late = null;
            return (taken, terminated, truncated);
        }

        private void Change(string what, double reward, bool terminated, bool truncated)
        {
            (this.reward, this.terminated, this.truncated) = (reward, terminated, truncated);
            if (!Inside) Late = what;
        }

        private double Finite(double number) => Math.Abs(number) < double.PositiveInfinity
            ? number
            : throw new MessageException("bad-reward",
                FormattableString.Invariant($"the reward of agent '{Name}' is {number}, which is not finite"));
    }
}
