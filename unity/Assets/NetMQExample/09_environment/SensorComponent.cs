// Lesson 09 in Unity, a sensor: a component that sees for the agents above it. lesson 11 has one; one of your own:
//
//     public sealed class Radar : SensorComponent
//     {
//         public override object GetObservation() => Physics.OverlapSphere(transform.position, 5).Length;
//     }
//
// Use: put it on a game object somewhere below an agent's. Without a locator the key is the names of the game objects
// between the agent and this one; on the agent's own it is the name of its class. With one, such as ".eye", that stands
// behind them; "@.eye" begins at the agent's root.
using System;
using System.Collections.Generic;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>One value more for each answer to Python. While it is enabled it takes part.</summary>
    public abstract class SensorComponent : MonoBehaviour
    {
        [SerializeField, Tooltip("Where it goes")] private string locator = "";

        private Source place;

        /// <summary>All that are enabled now. For the main thread.</summary>
        public static List<Source> All { get; } = new List<Source>();

        /// <summary>The key of a sensor on the agent's own game object.</summary>
        protected virtual string Key => GetType().Name;

        private string FullName => $"{GetType().Name} on {name}";

        /// <summary>The value that it senses now, of any type that [Obs] takes.</summary>
        public abstract object GetObservation();

        /// <summary>Finds its agents, all of which are there by now. An override calls base.Start().</summary>
        protected virtual void Start()
        {
            try
            {
                // Without a reload of the scene Unity may start what lives on once more.
                All.Remove(place);
                var source = new Source(FullName, Where, Read);
                if (!source.Locator.Absolute)
                    throw new ArgumentException($"{FullName} has no agent above it, and its locator names none");
                place = source;
                All.Add(place);
            }
            catch (ArgumentException e)
            {
                Debug.LogError($"gave up: {e.Message}");
                enabled = false;
            }
        }

        /// <summary>Comes back. An override calls base.OnEnable().</summary>
        protected virtual void OnEnable()
        {
            if (place != null) All.Add(place);
        }

        /// <summary>Leaves. An override calls base.OnDisable().</summary>
        protected virtual void OnDisable() => All.Remove(place);

        // Below each of the agents above it; its key is the names of the game objects from the agent to here.
        private Locator Where()
        {
            var scopes = new List<string>();
            var keys = "";
            for (var at = transform; at != null; at = at.parent)
            {
                var agent = at.GetComponent<Agent>();
                if (agent != null) scopes.Add($"{LocatorMapping.Quoted(agent.Name)}@{keys}");
                keys = $"[{LocatorMapping.Quoted(at.name)}]{keys}";
            }
            var scope = scopes.Count > 0 ? Locator.Parse(string.Join(" & ", scopes)) : null;
            return AgentState.Parse(FullName, locator, GetComponent<Agent>() == null ? "" : Key, scope);
        }

        private object Read()
        {
            try { return Observed.Of(GetObservation()); }
            catch (MessageException e)
            {
                throw new MessageException(e.Code, $"{FullName}: {e.Text}");
            }
        }
    }
}
