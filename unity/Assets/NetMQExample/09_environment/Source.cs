// Lesson 09, sources: where a value that an agent sees comes from, and in whose observation it goes.
using System;
using System.Collections.Generic;
using System.Linq;

namespace NetMQExample
{
    /// <summary>One place where a value comes from, and where it goes.</summary>
    public sealed class Source
    {
        private readonly Func<Locator> place;

        public Source(string name, Locator locator, Func<object> read)
            : this(name, Always(Require.Given("locator", locator)), read) { }

        /// <summary>With a locator that names agents, whose names are not decided yet.</summary>
        public Source(string name, Func<Locator> place, Func<object> read)
        {
            Name = Require.Given("name", name);
            this.place = Require.Given("place", place);
            Read = Require.Given("read", read);
            Write = (to, form) => Observed.Write(read(), form, to);
            Place();
        }

        private static Func<Locator> Always(Locator locator) => () => locator;

        /// <summary>For a person who must mend something.</summary>
        public string Name { get; }

        /// <summary>Where it goes; it names agents.</summary>
        public Locator Locator { get; private set; }

        public Func<object> Read { get; }

        // Writes its value as it stands in a message: takes the form of the value before, and returns that of this one.
        internal Func<FrameBuffer, string, string> Write { get; set; }

        /// <summary>Whether its value goes into the observation of this agent, perhaps among others.</summary>
        public bool Names(string agent)
        {
            foreach (var mapping in Locator.Mappings) if (mapping.Names(agent)) return true;
            return false;
        }

        /// <summary>The canonical text of its places in the observation of one agent, which is not named.</summary>
        internal string For(string agent) =>
            string.Join(" & ", Locator.Mappings.Where(mapping => mapping.Names(agent)).Select(one => one.InIt)
                .OrderBy(text => text, StringComparer.Ordinal));

        /// <summary>The names of agents have been decided.</summary>
        internal void Place() => Locator = place();
    }
}
