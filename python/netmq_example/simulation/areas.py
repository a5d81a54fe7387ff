"""Lesson 10, areas: many copies of one simulation, and one message steps them all. In C#: AreaSimulator.cs.

A request to `reset` has the arrays `mask`, uint8 [N], and `seeds`, int64 [N]: which areas begin anew, and by which
chance; a third array is the state in which they all begin. A request to `step` has the actions, [N, …]; with a mask and
seeds after them some areas are reset in place of stepped. So it is the environment alone that decides who begins anew.
The answer has the observations [N, …], rewards float64 [N], terminated and truncated uint8 [N], whatever was asked.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from netmq_example.messages import Array, Message, MessageError
from netmq_example.simulation.simulation import Simulation
from netmq_example.simulation.simulator import Simulator
from netmq_example.spaces import from_array, pack, to_array, verdicts
from netmq_example.split_mix import draws


class AreaSimulator(Simulator):
    """Answers reset, step and render for all areas at once."""

    def __init__(self, areas: Sequence[Simulation]) -> None:
        super().__init__(areas[0])
        self.areas = areas

    def describe(self) -> Message:
        hello = super().describe()
        hello.values["areas"] = len(self.areas)
        return hello

    def do(self, request: Message) -> Message:
        count, arrays = len(self.areas), list(request.arrays)
        if request.kind == "render":
            pictures = [to_array(area.render(), np.uint8) for area in self.areas]
            return Message("picture", request.id, {}, pictures)
        if request.kind not in ("reset", "step"):
            raise MessageError("unknown-kind", f"kind {request.kind!a:.40} is none of reset, step, render, close")
        step = request.kind == "step"
        # All of them are looked at before the first area moves: half a step would be none.
        actions = [self.action(row) for row in self.rows(arrays.pop(0))] if step and arrays else []
        if len(arrays) not in ((0, 2) if actions else (2, 3)):
            cure = f"make_vec(…, num_envs={count}), and a name that is registered with vector_entry_point"
            raise MessageError("no-mask", f"this simulator has {count} areas: {cure}")
        lots = [self.lots(array, kind) for array, kind in zip(arrays, ("uint8", "int64"), strict=False)]
        mask, seeds = lots or 2 * [np.zeros(count)]
        state = [float(item) for array in arrays[2:] for item in array.numpy().flat]
        if len(state) not in (0, self.simulation.size):
            raise MessageError("bad-state", f"a state is {self.simulation.size} numbers, not {len(state)}")
        judged = [dict[str, Any](reward=0.0, terminated=False, truncated=False) for _ in self.areas]
        for number, area in enumerate(self.areas):
            if mask[number]:
                area.reset(draws(int(seeds[number])), request.values, state)
                self.episodes += 1
            elif step:
                area.apply(actions[number])
                judged[number] = area.judge()
                self.steps += 1
        return self.state(request, judged)

    def rows(self, array: Array) -> Any:
        rows = array.numpy()
        if rows.shape[:1] != (len(self.areas),):
            raise MessageError("wrong-areas", f"{rows.shape} is not one row for each of {len(self.areas)} areas")
        return rows

    def lots(self, array: Array, dtype: str) -> Any:
        if (array.dtype, array.shape) != (dtype, (len(self.areas),)):
            raise MessageError("wrong-areas", f"mask and seeds are not one for each of {len(self.areas)} areas")
        return array.numpy()

    def action(self, row: Any) -> Any:
        return from_array(self.simulation.action, [to_array(row, row.dtype)])

    def state(self, request: Message, judged: list[dict[str, Any]]) -> Message:
        arrays = verdicts(judged)
        seen = to_array([area.observe() for area in self.areas], self.simulation.observation.dtype)
        infos = pack([(number, info) for number, info in enumerate(judged) if info])
        return Message("state", request.id, {"infos": infos}, [seen, *arrays])
