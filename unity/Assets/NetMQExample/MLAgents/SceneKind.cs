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

    /// <summary>It is filled again and again, and then makes no garbage.</summary>
    internal sealed class SceneRowList
    {
        private readonly List<(int Id, int Group, float Reward, float GroupReward, Marks Mark)> rows =
            new List<(int, int, float, float, Marks)>();
        private readonly FrameBuffer values = new FrameBuffer(), masks = new FrameBuffer();
        private readonly Columns kindOf;
        private bool grouped, masked;

        public SceneRowList(Columns kindOf) => this.kindOf = kindOf;

        /// <summary>Adds what an agent sees now, right from its sensors.</summary>
        public void Add(AgentLife agent, Marks mark, int rowBytes)
        {
            var begin = values.Count;
            var complete = false;
            try
            {
                foreach (var sensor in agent.Sensors) SensorRows.Write(sensor, values);
                complete = values.Count - begin == rowBytes;
            }
            finally
            {
                // A sensor of the user's has thrown: no half of a row may be left.
                if (!complete) values.Cut(begin);
            }
            if (!complete)
                throw new UnityAgentsException($"{agent.Name}: a sensor has changed its size, which it never may: "
                    + "return the same GetObservationSpec each time");
            rows.Add((agent.Id, agent.GroupId, agent.RowReward, agent.RowGroupReward, mark | Marks.Seen));
            grouped |= agent.GroupId != 0;
            if ((mark & Marks.Wants) == 0) return;
            masked |= agent.Mask.Any;
            masks.Write(agent.Mask.Bytes);
        }

        public void Write(StepAnswer answer, int kind)
        {
            if (rows.Count == 0) return;
            var columns = kindOf | Columns.Ids | (grouped ? Columns.Groups : 0) | (masked ? Columns.Masks : 0);
            answer.BeginSection(kind, rows.Count, columns);
            var to = answer.BeginColumn();
            foreach (var row in rows) to.Write((uint)row.Id);
            if (grouped)
            {
                answer.BeginColumn();
                foreach (var row in rows) to.Write((uint)row.Group);
                foreach (var row in rows) to.Write(row.GroupReward);
            }
            if (masked)
            {
                answer.BeginColumn();
                to.Write((uint)(masks.Count / rows.Count));
                to.Write(masks.From(0).Span);
            }
            for (var i = 0; i < rows.Count; i++) answer.Set(i, rows[i].Reward, rows[i].Mark, null);
            answer.BeginValues(rows.Count, false).Write(values.From(0).Span);
            answer.EndSection();
            rows.Clear();
            values.Clear();
            masks.Clear();
            grouped = masked = false;
        }
    }
}
