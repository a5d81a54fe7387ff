// ML-Agents' shape, a kind: the agents of one behavior, with their rows for the next answer.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Runtime.InteropServices;
using NetMQExample.MLAgents.Sensors;

namespace NetMQExample.MLAgents
{
    /// <summary>All agents of a behavior have the same sizes.</summary>
    internal sealed class SceneKind
    {
        private readonly SceneRowList wanting = new SceneRowList(Columns.None), ended = new SceneRowList(Columns.Ended);
        // Those that wanted an action in the answer before; and those of the next one.
        private List<AgentLife> asked = new List<AgentLife>(), next = new List<AgentLife>();
        private readonly string sizes;
        private readonly int number, continuous, branches, rowBytes;

        public SceneKind(int number, AgentLife first)
        {
            this.number = number;
            Behavior = first.Behavior;
            continuous = first.Spec.NumContinuousActions;
            branches = first.Spec.NumDiscreteActions;
            rowBytes = first.Sensors.Sum(SensorRows.Size);
            sizes = SizesOf(first);
            Description = new Dictionary<string, object>
            {
                ["name"] = first.Parameters.BehaviorName,
                ["team"] = (long)first.Parameters.TeamId,
                ["continuous"] = (long)continuous,
                ["branches"] = first.Branches.Select(size => (object)(long)size).ToList(),
                ["sensors"] = first.Sensors.Select(Describe).ToList(),
            };
        }

        public string Behavior { get; }
        public Dictionary<string, object> Description { get; }

        /// <summary>Whether any of them wanted an action in the answer before.</summary>
        public bool Asked => asked.Count > 0;

        /// <exception cref="UnityAgentsException">The agent has other sizes than the first one.</exception>
        public void Check(AgentLife agent)
        {
            if (SizesOf(agent) != sizes)
                throw new UnityAgentsException($"{agent.Name} has {SizesOf(agent)}, and another agent of the behavior "
                    + $"{Behavior} has {sizes}: give it another Behavior Name, or the same sensors and actions");
        }

        public void Want(AgentLife agent)
        {
            wanting.Add(agent, Marks.Wants, rowBytes);
            next.Add(agent);
        }

        public void End(AgentLife agent, bool interrupted) =>
            ended.Add(agent, interrupted ? Marks.Truncated : Marks.Terminated, rowBytes);

        /// <summary>Writes the rows of those that have ended, which are no more then.</summary>
        public void WriteEnded(StepAnswer answer) => ended.Write(answer, number);

        /// <summary>The same for those that want an action.</summary>
        public void WriteWanting(StepAnswer answer)
        {
            wanting.Write(answer, number);
            (asked, next) = (next, asked);
            next.Clear();
        }

        /// <exception cref="MessageException">These are no actions for those who wanted one.</exception>
        public void Check(RequestSection section)
        {
            var size = 4 * (continuous + branches);
            if (section.Count != asked.Count)
                throw new MessageException("bad-actions",
                    $"{section.Count} actions of {Behavior}, of which {asked.Count} agents wanted one");
            for (var row = 0; row < section.Count; row++)
                if (section.OrderOf(row) != Order.Step || section.Row(row).Length != size)
                    throw new MessageException("bad-actions", $"an action of {Behavior} is {continuous} float32 and "
                        + $"{branches} int32, not {section.Row(row).Length} bytes");
        }

        public void Take(RequestSection section)
        {
            for (var row = 0; row < section.Count; row++)
            {
                var bytes = section.Row(row).Span;
                var decided = asked[row].Decided;
                bytes.Slice(0, 4 * continuous).CopyTo(MemoryMarshal.AsBytes<float>(decided.ContinuousActions.Array));
                bytes.Slice(4 * continuous).CopyTo(MemoryMarshal.AsBytes<int>(decided.DiscreteActions.Array));
            }
        }

        private static string SizesOf(AgentLife agent)
        {
            var seen = agent.Sensors.Select(
                sensor => $"{sensor.GetName()} ({string.Join(" x ", sensor.GetObservationSpec().Shape)})");
            return $"{agent.Spec.NumContinuousActions} continuous actions, "
                + $"branches [{string.Join(", ", agent.Branches)}], sensors [{string.Join(", ", seen)}]";
        }

        private static object Describe(ISensor sensor)
        {
            var spec = sensor.GetObservationSpec();
            return new Dictionary<string, object>
            {
                ["name"] = sensor.GetName(),
                ["shape"] = spec.Shape.Select(size => (object)(long)size).ToList(),
                ["dtype"] = SensorRows.IsPicture(sensor) ? "uint8" : "float32",
                ["type"] = (long)spec.ObservationType,
                ["properties"] = spec.DimensionProperties.Select(one => (object)(long)one).ToList(),
            };
        }
    }
}
