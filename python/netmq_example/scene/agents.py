"""Agents: several of them in one world, and one message has an action for each that lives.

    EnvironmentClient("tcp://127.0.0.1:5560", timeout=30).run(AgentSimulator(Pursuit()))

A hello lists the agents and their spaces in `agents`. A record (records.py) has a row for each of them, in that order,
and says of each whether it steps: all that live do. An agent that is over has no part in the next step. The answer's
options are the game's infos, [[agent, info], …]. The message `info` brings an info, as [agent, info], and takes back
the infos since then. In C# it is AgentSimulator.cs.
"""

import struct
from typing import Any

from netmq_example.messages import Message, MessageError
from netmq_example.scene.answers import answer_to, hello_of, options_in, picture_of, unknown
from netmq_example.scene.simulation import AgentSimulation, RealTime
from netmq_example.scene.simulator import SimulatorBase
from netmq_example.wire import trees
from netmq_example.wire.records import NOTHING, RESET, STEP, Record
from netmq_example.wire.space_bytes import Bytes
from netmq_example.wire.spaces import described
from netmq_example.wire.split_mix import draws


class AgentSimulator(SimulatorBase):
    """Answers reset, step, info and render for a game."""

    def __init__(self, game: AgentSimulation) -> None:
        self.game = RealTime(game)
        super().__init__(game.name)
        self.living: list[str] = []
        self.bytes = {agent: [Bytes(space) for space in spaces] for agent, spaces in game.agents.items()}

    def describe(self) -> Message:
        agents = [
            [agent, {"observation": described(observation), "action": described(action)}]
            for agent, (observation, action) in self.game.agents.items()
        ]
        return hello_of(self.name, self.game.dt, {"agents": agents})

    def do(self, request: Record) -> Record:
        agents = list(self.game.agents)
        if len(request.flags) != len(agents):
            raise MessageError("wrong-agents", f"{len(request.flags)} rows, but there are {len(agents)} agents")
        outcomes: dict[str, dict[str, Any]]
        if set(request.flags) == {RESET}:
            (seed, *_) = struct.unpack(f"<{len(agents)}q", request.numbers)
            self.game.reset(draws(seed), options_in(request))
            self.living = agents
            self.episodes += 1
            outcomes = {agent: {} for agent in agents}
        else:
            self.game.apply(self.actions(dict(zip(agents, zip(request.flags, request.rows, strict=True), strict=True))))
            self.steps += 1
            outcomes = {agent: self.game.reward_and_end(agent) for agent in self.living}
        rows = [self.bytes[name][0].write(self.game.observe(name)) if name in outcomes else b"" for name in agents]
        answer = answer_to(request, agents, [outcomes.get(name, {}) for name in agents], rows, self.game.infos.take())
        over = {name for name, ends in zip(agents, answer.flags, strict=True) if ends}
        self.living = [name for name in self.living if name not in over]
        return answer

    def actions(self, asked: dict[str, tuple[int, Any]]) -> dict[str, Any]:
        """All of them are looked at before anything moves."""
        stepping = [name for name, (order, _) in asked.items() if order != NOTHING]
        if not self.living or stepping != self.living or any(asked[name][0] != STEP for name in stepping):
            raise MessageError("wrong-agents", f"actions of {stepping}, but those that live are {self.living}")
        return {name: self.bytes[name][1].read(asked[name][1]) for name in stepping}

    def say(self, request: Message) -> Message:
        if request.kind == "render":
            return picture_of(request, [self.game.render()])
        if request.kind != "info":
            raise unknown(request, "info, render")
        agent, info = info_of(request)
        if agent not in ("", *self.game.agents):
            raise MessageError("unknown-agent", f"{agent!a:.40} is none of {list(self.game.agents)}")
        if type(info) is not dict:
            raise MessageError("bad-info", f"an info is a dict, not {info!a:.40}")
        self.game.on_info(agent, info)
        infos = self.game.infos.take()
        return Message("told", request.id, {}, [trees.array_of(infos)])


def info_of(request: Message) -> tuple[str, Any]:
    """An info: the agent that it is for, or "" for the environment, and its value."""
    pair = trees.read(request.arrays[0].data) if len(request.arrays) == 1 else None
    if type(pair) is not list or len(pair) != 2 or not isinstance(pair[0], str):
        raise MessageError("bad-info", f"{pair!a:.40} is no name with an info")
    return pair[0], pair[1]
