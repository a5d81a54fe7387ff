// ML-Agents' shape, rows: what agents of one kind have seen and earned, as it goes into one section of an answer.
using System;
using System.Collections.Generic;
using NetMQExample.MLAgents.Sensors;

namespace NetMQExample.MLAgents
{
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
