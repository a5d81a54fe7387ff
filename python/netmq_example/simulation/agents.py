"""Agents: several of them in one world, and one message has an array for each that lives.

    EnvironmentClient("tcp://127.0.0.1:5560", timeout=30).run(AgentSimulator(Pursuit()))

A hello lists in `agents` who there is and of what kind their spaces are. A `step` has an action for each agent that
lives, in the order of the hello. The answer's `infos` name these agents; its arrays are rewards float64 [n], terminated
and truncated uint8 [n], and what each of them sees. An agent that is over then has no part in the next step.
An `info` brings infos for agents, and takes back in `told` those of the game, as each answer does. In C# it is
AgentSimulator.cs.
"""

from typing import Any

import numpy as np

from netmq_example.infos import pack, unpack
from netmq_example.messages import Array, Message, MessageError, take
from netmq_example.simulation.simulation import AgentSimulation, RealTime
from netmq_example.simulation.simulator import SimulatorBase, verdicts
from netmq_example.spaces import described, from_array, to_array
from netmq_example.split_mix import draws


class AgentSimulator(SimulatorBase):
    """Answers reset, step, info and render for a game."""

    def __init__(self, game: AgentSimulation) -> None:
        self.game = RealTime(game)
        super().__init__(game.name)
        self.living: list[str] = []

    def describe(self) -> Message:
        kinds: list[tuple[str, dict[str, Any]]] = []
        arrays: list[Array] = []
        for agent, (observation, action) in self.game.agents.items():
            seen, seen_arrays = described(observation)
            done, done_arrays = described(action)
            kinds.append((agent, {"observation": seen, "action": done}))
            arrays += seen_arrays + done_arrays
        return Message("hello", 0, {"name": self.name, "dt": self.game.dt, "agents": pack(kinds)}, arrays)

    def do(self, request: Message) -> Message:
        match request.kind:
            case "reset":
                self.game.reset(draws(take(request.values, "seed", int)), request.values)
                self.living = list(self.game.agents)
                self.episodes += 1
                start = {"reward": 0.0, "terminated": False, "truncated": False}
                return self.state(request, {agent: dict(start) for agent in self.living})
            case "step":
                self.game.apply(self.actions(request))
                self.steps += 1
                return self.state(request, {agent: self.game.judge(agent) for agent in self.living})
            case "info":
                for agent, info in unpack(take(request.values, "infos", str)):
                    if agent not in ("", *self.game.agents):
                        raise MessageError("unknown-agent", f"{agent!a:.40} is none of {list(self.game.agents)}")
                    self.game.on_info(agent, info)
                return Message("told", request.id, {"told": self.game.infos.take()})
            case "render":
                return Message("picture", request.id, {}, [to_array(self.game.render(), np.uint8)])
        raise MessageError("unknown-kind", f"kind {request.kind!a:.40} is none of reset, step, info, render, close")

    def actions(self, request: Message) -> dict[str, Any]:
        if not self.living or len(request.arrays) != len(self.living):
            raise MessageError("wrong-agents", f"{len(request.arrays)} actions, but {len(self.living)} agents live")
        # All of them are looked at before anything moves.
        return {
            agent: from_array(self.game.agents[agent][1], [array])
            for agent, array in zip(self.living, request.arrays, strict=True)
        }

    def state(self, request: Message, judged: dict[str, dict[str, Any]]) -> Message:
        arrays = verdicts(list(judged.values()))
        arrays += [to_array(self.game.observe(agent), self.game.agents[agent][0].dtype) for agent in judged]
        over = arrays[1].numpy() | arrays[2].numpy()
        self.living = [agent for agent, ended in zip(judged, over, strict=True) if not ended]
        values = {"infos": pack(list(judged.items())), "told": self.game.infos.take()}
        return Message("state", request.id, values, arrays)
