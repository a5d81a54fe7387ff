"""Areas: many copies of one simulation, and one message steps them all.

    EnvironmentClient("tcp://127.0.0.1:5560", timeout=30).run(AreaSimulator([CartPole() for _ in range(16)]))

A request to `reset` has the arrays `mask`, uint8 [N], and `seeds`, int64 [N]: which areas begin anew, and by which
chance; a third array is the state in which they all begin. A request to `step` has the actions, [N, …]; with a mask and
seeds after them some areas are reset in place of stepped. So it is the environment alone that decides who begins anew.
The answer has the observations [N, …], rewards float64 [N], terminated and truncated uint8 [N], whatever was asked.
In C# it is AreaSimulator.cs.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from netmq_example import check
from netmq_example.infos import pack
from netmq_example.messages import Array, Message, MessageError
from netmq_example.simulation.simulation import Simulation
from netmq_example.simulation.simulator import Simulator, verdicts
from netmq_example.spaces import from_array, to_array
from netmq_example.split_mix import draws


class AreaSimulator(Simulator):
    """Answers reset, step and render for all areas at once."""

    def __init__(self, areas: Sequence[Simulation]) -> None:
        if not isinstance(areas, Sequence) or not areas:
            raise ValueError(f"areas takes a list of simulations, at least one, not {areas!r:.40}")
        for area in areas:
            check.instance("areas", area, Simulation)
        super().__init__(areas[0])
        self.areas = areas

    def describe(self) -> Message:
        hello = super().describe()
        hello.values["areas"] = len(self.areas)
        return hello

    def do(self, request: Message) -> Message:
        if request.kind == "render":
            pictures = [to_array(area.render(), np.uint8) for area in self.areas]
            return Message("picture", request.id, {}, pictures)
        if request.kind not in ("reset", "step"):
            raise MessageError("unknown-kind", f"kind {request.kind!a:.40} is none of reset, step, render, close")
        count = len(self.areas)
        arrays = list(request.arrays)
        # All actions are looked at before the first area moves: half a step would be none.
        actions = self.actions(arrays.pop(0)) if request.kind == "step" and arrays else []
        if len(arrays) not in ((0, 2) if actions else (2, 3)):
            cure = f"make_vec(…, num_envs={count}), and a name that is registered with vector_entry_point"
            raise MessageError("no-mask", f"this simulator has {count} areas: {cure}")
        mask = self.one_each(arrays[0], "uint8") if arrays else np.zeros(count)
        seeds = self.one_each(arrays[1], "int64") if arrays else np.zeros(count)
        state = self.state_of(arrays[2:])
        judged = [dict[str, Any](reward=0.0, terminated=False, truncated=False) for _ in self.areas]
        for number, area in enumerate(self.areas):
            if mask[number]:
                area.reset(draws(int(seeds[number])), request.values, state)
                self.episodes += 1
            elif actions:
                area.apply(actions[number])
                judged[number] = area.judge()
                self.steps += 1
        return self.state(request, judged)

    def actions(self, array: Array) -> list[Any]:
        rows = array.numpy()
        if rows.shape[:1] != (len(self.areas),):
            raise MessageError("wrong-areas", f"{rows.shape} is not one row for each of {len(self.areas)} areas")
        return [from_array(self.simulation.action, [to_array(row, row.dtype)]) for row in rows]

    def one_each(self, array: Array, dtype: str) -> Any:
        if (array.dtype, array.shape) != (dtype, (len(self.areas),)):
            raise MessageError("wrong-areas", f"mask and seeds are not one for each of {len(self.areas)} areas")
        return array.numpy()

    def state(self, request: Message, judged: list[dict[str, Any]]) -> Message:
        arrays = verdicts(judged)
        seen = to_array([area.observe() for area in self.areas], self.simulation.observation.dtype)
        infos = pack([(number, info) for number, info in enumerate(judged) if info])
        return Message("state", request.id, {"infos": infos}, [seen, *arrays])
