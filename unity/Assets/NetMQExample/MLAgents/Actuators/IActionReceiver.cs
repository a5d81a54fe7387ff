// ML-Agents' shape, parts of an agent: it gets actions, forbids choices and has a heuristic. Scripts with actuators of
// their own compile; an agent says that they do not act.
using System;
using System.Collections.Generic;
using System.Linq;
using UnityEngine;

namespace NetMQExample.MLAgents.Actuators
{
    /// <summary>A thing that acts.</summary>
    public interface IActionReceiver
    {
        void OnActionReceived(ActionBuffers actionBuffers);

        void WriteDiscreteActionMask(IDiscreteActionMask actionMask);
    }

    /// <summary>A thing that decides by itself where Python does not.</summary>
    public interface IHeuristicProvider
    {
        void Heuristic(in ActionBuffers actionBuffersOut);
    }

    /// <summary>A part of an agent that acts for itself. It compiles, and is not called.</summary>
    public interface IActuator : IActionReceiver, IHeuristicProvider
    {
        ActionSpec ActionSpec { get; }

        string Name { get; }

        void ResetData();
    }

    /// <summary>Makes actuators, which are not called.</summary>
    public abstract class ActuatorComponent : MonoBehaviour
    {
        public abstract ActionSpec ActionSpec { get; }

        public abstract IActuator[] CreateActuators();
    }

    /// <summary>Where an agent forbids choices. All are allowed before each decision.</summary>
    public interface IDiscreteActionMask
    {
        /// <summary>Allows or forbids one choice of a branch.</summary>
        void SetActionEnabled(int branch, int actionIndex, bool isEnabled);

        /// <summary>Forbids some choices of a branch, as in ML-Agents 1.</summary>
        void WriteMask(int branch, IEnumerable<int> actionIndices);
    }

    /// <summary>A byte for each choice, all branches one after the other; 1: forbidden.</summary>
    internal sealed class DiscreteActionMask : IDiscreteActionMask
    {
        private readonly int[] branches;
        private readonly byte[] forbidden;

        public DiscreteActionMask(int[] branchSizes) =>
            (branches, forbidden) = (branchSizes, new byte[branchSizes.Sum()]);

        public bool Any => Array.IndexOf(forbidden, (byte)1) >= 0;

        /// <summary>As they stand in a record.</summary>
        public byte[] Bytes => forbidden;

        public void SetActionEnabled(int branch, int actionIndex, bool isEnabled)
        {
            if (branch < 0 || branch >= branches.Length || actionIndex < 0 || actionIndex >= branches[branch])
                throw new UnityAgentsException($"a mask for choice {actionIndex} of branch {branch}: Behavior "
                    + $"Parameters has branches of {string.Join(", ", branches)} choices, and both are counted from 0");
            forbidden[Begin(branch) + actionIndex] = (byte)(isEnabled ? 0 : 1);
        }

        public void WriteMask(int branch, IEnumerable<int> actionIndices)
        {
            foreach (var index in actionIndices) SetActionEnabled(branch, index, false);
        }

        public void Clear() => Array.Clear(forbidden, 0, forbidden.Length);

        /// <exception cref="UnityAgentsException">A branch has no choice left.</exception>
        public void Check()
        {
            for (var branch = 0; branch < branches.Length; branch++)
                if (Array.IndexOf(forbidden, (byte)0, Begin(branch), branches[branch]) < 0)
                    throw new UnityAgentsException(
                        $"all choices of branch {branch} are masked: WriteDiscreteActionMask must leave one");
        }

        // By hand: each decision looks, and Linq makes garbage.
        private int Begin(int branch)
        {
            var begin = 0;
            for (var i = 0; i < branch; i++) begin += branches[i];
            return begin;
        }
    }
}
