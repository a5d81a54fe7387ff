// ML-Agents' shape, an agent's methods of 2020, in which all actions are floats; and what it writes without override.
using System;
using System.Collections.Generic;
using System.Reflection;
using NetMQExample.MLAgents.Actuators;
using UnityEngine;

namespace NetMQExample.MLAgents
{
#pragma warning disable CS0618 // They are obsolete for whoever writes an agent.
    /// <summary>Passes ActionBuffers on as floats, to an agent that does not take them.</summary>
    internal sealed class AgentOfOld
    {
        private const BindingFlags Declared =
            BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic | BindingFlags.DeclaredOnly;
        private static readonly HashSet<Type> Looked = new HashSet<Type>();

        private readonly Agent agent;
        private float[] floats;
        private bool said;

        public AgentOfOld(Agent agent) => this.agent = agent;

        public void Receive(ActionBuffers actions)
        {
            if (!IsMixed(actions)) agent.OnActionReceived(Floats(actions));
        }

        public void Decide(ActionBuffers decided)
        {
            if (IsMixed(decided))
            {
                HasNone();
                return;
            }
            agent.Heuristic(Floats(decided));
            var (numbers, choices) = (decided.ContinuousActions, decided.DiscreteActions);
            for (var i = 0; i < numbers.Length; i++) numbers[i] = floats[i];
            for (var i = 0; i < choices.Length; i++) choices[i] = (int)floats[i];
        }

        public void HasNone()
        {
            if (!said)
                Debug.LogWarning($"{agent.name}: nobody decides for it: write Heuristic in {agent.GetType().Name}, "
                    + "or start Python before you press Play");
            said = true;
        }

        /// <summary>Unity calls the most derived of its messages: one that is no override hides the agent's.</summary>
        public static void LookForHidden(Agent agent)
        {
            if (!Looked.Add(agent.GetType())) return;
            for (var type = agent.GetType(); type != typeof(Agent); type = type.BaseType)
                foreach (var name in new[] { "OnEnable", "OnDisable" })
                {
                    var hiding = type.GetMethod(name, Declared, null, Type.EmptyTypes, null);
                    if (hiding != null && hiding.GetBaseDefinition().DeclaringType != typeof(Agent))
                        Debug.LogError($"trouble: {type.Name}.{name} hides the agent's own: "
                            + $"write protected override void {name}() with base.{name}(); in it");
                }
        }

        // Agents with both kinds of actions came later than these methods.
        private static bool IsMixed(ActionBuffers actions) =>
            actions.ContinuousActions.Length > 0 && actions.DiscreteActions.Length > 0;

        private float[] Floats(ActionBuffers actions)
        {
            var (numbers, choices) = (actions.ContinuousActions, actions.DiscreteActions);
            floats ??= new float[numbers.Length + choices.Length];
            for (var i = 0; i < numbers.Length; i++) floats[i] = numbers[i];
            for (var i = 0; i < choices.Length; i++) floats[i] = choices[i];
            return floats;
        }
    }
#pragma warning restore CS0618
}
