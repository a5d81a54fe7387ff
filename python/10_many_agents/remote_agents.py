"""Lesson 10, the agents as Python sees them: their spaces, and what a message says of each.
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Space

# In its own lesson's folder; at home they lie beside this file.
sys.path += [str(Path(__file__).resolve().parents[1] / name) for name in ("05_messages", "09_environment")]
from infos import unpack
from messages import Array, Message, MessageError, take
from simulators import Simulators
from spaces import from_array, space_of

ENDPOINT = "tcp://127.0.0.1:5560"


class RemoteAgents:
    """`where` is what Simulators takes: endpoint, launch, wait, timeout, socket."""

    def __init__(self, name: str, **where: Any) -> None:
        self.name, self.dt, self.spaces = name, 0.0, dict[str, tuple[Space[Any], Space[Any]]]()
        self.last = dict[str, Array]()
        self.simulators = Simulators(default=ENDPOINT, **where)
        self.ask = self.simulators.connection.ask

    def accept(self, hello: Message) -> None:
        if (name := take(hello.values, "name", str)) != self.name:
            raise MessageError("wrong-name", f"this environment is {self.name}, the simulator's is {name!a:.40}")
        arrays, spaces = list(hello.arrays), dict[str, tuple[Space[Any], Space[Any]]]()
        for agent, kinds in unpack(take(hello.values, "agents", str)):
            if agent in ("", "env", *spaces):
                raise MessageError("bad-agents", f"{agent!a:.40} is another agent, or stands for the environment")
            seen, done = (space_of(take(kinds, which, str), arrays) for which in ("observation", "action"))
            spaces[agent] = (seen, done)
        if self.spaces and spaces != self.spaces:
            raise MessageError("other-spaces", f"the simulator before this one had {self.spaces!s:.80}")
        # The same objects for ever: whoever draws actions by chance has seeded them.
        self.spaces, self.dt = self.spaces or spaces, take(hello.values, "dt", float)

    def read(self, state: Message, living: list[str]) -> tuple[dict[str, Any], ...]:
        """Observations, rewards, terminated, truncated and infos, each by agent."""
        infos = unpack(take(state.values, "infos", str), own=("told", "lost"))
        if (names := [name for name, _ in infos]) != living or len(state.arrays) != 3 + len(living):
            raise MessageError("wrong-agents", f"a state of {names!s:.80}, but those that live are {living}")
        reward, *flags = ([array] for array in state.arrays[:3])
        most, count = np.finfo(np.float64).max, (len(living),)
        rewards = map(float, from_array(Box(-most, most, count, np.float64), reward))
        terminated, truncated = (map(bool, from_array(Box(0, 1, count, np.uint8), flag)) for flag in flags)
        last = dict(zip(living, state.arrays[3:], strict=True))
        seen, said = self.seen(last), {"told": heard} if (heard := told(state)) else {}
        by_agent = [dict(zip(living, each, strict=True)) for each in (rewards, terminated, truncated)]
        self.last = last
        return seen, *by_agent, {agent: {**info, **said} for agent, info in infos}

    def seen(self, arrays: dict[str, Array]) -> dict[str, Any]:
        return {agent: from_array(self.spaces[agent][0], [array]) for agent, array in arrays.items()}


def told(answer: Message) -> dict[str, list[Any]]:
    """What the game has said since the answer before: lists of infos by agent, those of the environment as `env`."""
    said = dict[str, list[Any]]()
    for agent, info in unpack(answer.values.get("told", "[]")):
        said.setdefault(agent or "env", []).append(info)
    return said
