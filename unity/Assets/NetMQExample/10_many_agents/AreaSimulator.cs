// Lesson 10, areas: many copies of one simulation, and one message steps them all.
//
// A request to reset has the arrays mask, uint8 [N], and seeds, int64 [N]: which areas begin anew, and by which chance;
// a third array is the state in which they all begin. A request to step has the actions, [N, …]; with a mask and seeds
// after them some areas are reset in place of stepped. So it is Python alone that decides who begins anew. The answer
// has the observations [N, …], rewards float64 [N], terminated and truncated uint8 [N], whatever was asked.
// The Python side is python/netmq_example/envs/vector_env.py.
// Trouble: start it with another number of areas than num_envs.
using System;
using System.Collections.Generic;
using System.Linq;

namespace NetMQExample
{
    /// <summary>Answers reset, step and render for all areas at once.</summary>
    public sealed class AreaSimulator : SimulatorBase
    {
        private readonly ISimulation[] areas;

        /// <summary>For simulations of one kind, at least one, which from then on nobody else steps.</summary>
        public AreaSimulator(IEnumerable<ISimulation> areas) => this.areas = Require.Given("areas", areas).ToArray();

        /// <summary>Called when all that step have done their actions, and before any begins anew: in Unity physics
        /// moves then.</summary>
        public Action Moved { get; set; } = () => { };

        /// <inheritdoc/>
        public override string Name => areas[0].Name;

        /// <inheritdoc/>
        protected override Message Describe()
        {
            var hello = new Simulator(areas[0]).Hello();
            hello.Values["areas"] = areas.Length;
            return hello;
        }

        /// <inheritdoc/>
        protected override Message Do(Message request)
        {
            if (request.Kind == "render")
            {
                var pictures = new Message("picture", request.Id);
                pictures.Arrays.AddRange(areas.Select(area => area.Render()));
                return pictures;
            }
            if (request.Kind != "reset" && request.Kind != "step")
                throw new MessageException("unknown-kind",
                    $"kind {MessageJson.Shown(request.Kind)} is none of reset, step, render, close");
            var arrays = new Queue<MessageArray>(request.Arrays);
            // All of them are looked at before the first area moves: half a step would be none.
            var actions = request.Kind == "step" && arrays.Count > 0
                ? Rows(arrays.Dequeue()).Select(row => areas[0].Action.Read(new[] { row })).ToArray()
                : null;
            if (actions == null ? arrays.Count != 2 && arrays.Count != 3 : arrays.Count != 0 && arrays.Count != 2)
                throw new MessageException("no-mask",
                    $"this simulator has {areas.Length} areas: make_vec(…, num_envs={areas.Length}), and a name "
                    + "that is registered with vector_entry_point");
            var mask = arrays.Count > 0 ? Numbers<byte>(arrays.Dequeue()) : new byte[areas.Length];
            var seeds = arrays.Count > 0 ? Numbers<long>(arrays.Dequeue()) : new long[areas.Length];
            var state = arrays.SelectMany(GymSpace.Numbers).ToArray();
            if (state.Length != 0 && state.Length != areas[0].StateSize)
                throw new MessageException("bad-state",
                    $"a state is {areas[0].StateSize} numbers, not {state.Length}");
            bool Begins(int area) => mask[area] != 0;
            Move(actions, Begins);
            foreach (var area in Enumerable.Range(0, areas.Length).Where(Begins))
            {
                areas[area].ResetWorld(new Chance(seeds[area]), request.Values, state);
                Episodes++;
            }
            return State(request.Id, area => actions == null || Begins(area));
        }

        private void Move(double[][] actions, Func<int, bool> begins)
        {
            if (actions == null) return;
            for (var area = 0; area < areas.Length; area++)
            {
                if (begins(area)) continue;
                areas[area].Apply(actions[area]);
                Steps++;
            }
            // In Unity physics, once for all of them.
            Moved();
        }

        private Message State(long id, Func<int, bool> begun)
        {
            var infos = areas.Select(area => new Dictionary<string, object>()).ToArray();
            var judged = areas.Select((area, i) => begun(i) ? (0, false, false) : area.Judge(infos[i])).ToArray();
            var answer = new Message("state", id);
            answer.Values["infos"] = Infos.Pack(infos.Select((info, area) =>
                ((object)area, (IReadOnlyDictionary<string, object>)info)).Where(one => one.Item2.Count > 0));
            answer.Arrays.Add(Batch(areas.Select(area => area.Observe()).ToArray()));
            answer.Arrays.AddRange(Infos.Judged(judged));
            return answer;
        }

        private T[] Numbers<T>(MessageArray array) where T : struct
        {
            if (array.Shape.SequenceEqual(new[] { areas.Length }) && array.Items<T>().Length == areas.Length)
                return array.Items<T>().ToArray();
            throw new MessageException("wrong-areas", $"mask and seeds are not one for each of {areas.Length} areas");
        }

        private IEnumerable<MessageArray> Rows(MessageArray batch)
        {
            if (batch.Shape.Length == 0 || batch.Shape[0] != areas.Length)
                throw new MessageException("wrong-areas", $"the actions are not one for each of {areas.Length} areas");
            var size = batch.Data.Length / areas.Length;
            return areas.Select((_, i) =>
                new MessageArray(batch.Dtype, batch.Data.Slice(i * size, size), batch.Shape.Skip(1).ToArray()));
        }

        private static MessageArray Batch(MessageArray[] rows)
        {
            var size = rows[0].Data.Length;
            var data = new byte[rows.Length * size];
            for (var i = 0; i < rows.Length; i++) rows[i].Data.CopyTo(data.AsMemory(i * size));
            return new MessageArray(rows[0].Dtype, data, rows[0].Shape.Prepend(rows.Length).ToArray());
        }
    }
}
