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
        private readonly int continuous, branches, rowBytes;

        public SceneKind(int number, AgentLife first)
        {
            Number = number;
            Behavior = first.Behavior;
            continuous = first.Spec.NumContinuousActions;
            branches = first.Spec.NumDiscreteActions;
            foreach (var sensor in first.Sensors) rowBytes += SensorRows.Size(sensor);
            sizes = SizesOf(first);
            Description = new Dictionary<string, object>
            {
                ["name"] = first.Parameters.BehaviorName,
                ["team"] = (long)first.Parameters.TeamId,
                ["continuous"] = (long)continuous,
                ["branches"] = BranchesOf(first).Select(size => (object)(long)size).ToList(),
                ["sensors"] = first.Sensors.Select(sensor => (object)Describe(sensor)).ToList(),
            };
        }

        public int Number { get; }

        public string Behavior { get; }

        public Dictionary<string, object> Description { get; }

        /// <exception cref="UnityAgentsException">The agent has other sizes than the first one.</exception>
        public void Check(AgentLife agent)
        {
            if (SizesOf(agent) != sizes)
                throw new UnityAgentsException($"{agent.Name} has {SizesOf(agent)}, and another agent of the behavior "
                    + $"{Behavior} has {sizes}: give it another Behavior Name, or the same sensors and actions");
        }

        /// <summary>One wants an action.</summary>
        public void Want(AgentLife agent)
        {
            wanting.Add(agent, Marks.Wants, rowBytes);
            next.Add(agent);
        }

        /// <summary>The episode of one is over.</summary>
        public void End(AgentLife agent, bool interrupted) =>
            ended.Add(agent, interrupted ? Marks.Truncated : Marks.Terminated, rowBytes);

        /// <summary>Writes the rows of those that have ended, which are no more then.</summary>
        public void WriteEnded(StepAnswer answer) => ended.Write(answer, Number);

        /// <summary>The same for those that want an action.</summary>
        /// <returns>Whether anybody does.</returns>
        public bool WriteWanting(StepAnswer answer)
        {
            wanting.Write(answer, Number);
            var before = asked;
            asked = next;
            next = before;
            next.Clear();
            return asked.Count > 0;
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

        /// <summary>Gives each agent its action.</summary>
        public void Take(RequestSection section)
        {
            for (var row = 0; row < section.Count; row++)
            {
                var (numbers, choices) = (asked[row].Decided.ContinuousActions, asked[row].Decided.DiscreteActions);
                var bytes = section.Row(row).Span;
                MemoryMarshal.Cast<byte, float>(bytes.Slice(0, 4 * continuous)).CopyTo(numbers.Array);
                MemoryMarshal.Cast<byte, int>(bytes.Slice(4 * continuous)).CopyTo(choices.Array);
            }
        }

        private static string SizesOf(AgentLife agent)
        {
            var seen = agent.Sensors.Select(sensor => $"{sensor.GetName()} ({string.Join(" x ", ShapeOf(sensor))})");
            return $"{agent.Spec.NumContinuousActions} continuous actions, "
                + $"branches [{string.Join(", ", BranchesOf(agent))}], sensors [{string.Join(", ", seen)}]";
        }

        private static int[] BranchesOf(AgentLife agent) => agent.Spec.BranchSizes ?? Array.Empty<int>();

        private static IEnumerable<int> ShapeOf(ISensor sensor)
        {
            var shape = sensor.GetObservationSpec().Shape;
            return Enumerable.Range(0, shape.Length).Select(at => shape[at]);
        }

        private static Dictionary<string, object> Describe(ISensor sensor)
        {
            var spec = sensor.GetObservationSpec();
            var properties = Enumerable.Range(0, spec.Shape.Length)
                .Select(at => (object)(long)spec.DimensionProperties[at]);
            return new Dictionary<string, object>
            {
                ["name"] = sensor.GetName(),
                ["shape"] = ShapeOf(sensor).Select(size => (object)(long)size).ToList(),
                ["dtype"] = SensorRows.IsPicture(sensor) ? "uint8" : "float32",
                ["type"] = (long)spec.ObservationType,
                ["properties"] = properties.ToList(),
            };
        }
    }
}
