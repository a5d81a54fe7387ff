"""Worlds of the scene's clock (tests/unity/play/MLAgentsWorlds.cs), driven by the kit's UnityEnvironment.

world = World(play, "A period=2 numbers=1", "A act 3: add 1, end")
world.reset()
world.step(7)
assert world.told() == ["A init", …]
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from netmq_example.mlagents_envs.base_env import ActionTuple
from netmq_example.mlagents_envs.environment import UnityEnvironment
from tests.programs import Program, steady_port

BALL = "Ball?team=0"


class Row(NamedTuple):
    """Python is told this of one agent."""

    what: str
    id: int
    reward: float
    # The first number that it sees: as a rule how often it has been observed.
    seen: float


class World:
    def __init__(self, play: Callable[..., Program], *words: str, **environment: Any) -> None:
        port = steady_port()
        self.program = play("clock", *words, "--mlagents-port", str(port))
        try:
            self.env = UnityEnvironment(base_port=port, **environment)
        except BaseException:
            self.program.kill()
            print(self.program.output)
            raise

    def reset(self) -> list[Row]:
        self.env.reset()
        return self.rows()

    def step(self, *numbers: float, choices: tuple[int, ...] = (), name: str = BALL) -> list[Row]:
        """The same action for all that want one; without it zeros."""
        if (numbers or choices) and (count := len(self.env.get_steps(name)[0])):
            action = ActionTuple(
                np.tile(np.array(numbers, np.float32), (count, 1)), np.tile(np.array(choices, np.int32), (count, 1))
            )
            self.env.set_actions(name, action)
        self.env.step()
        return self.rows(name)

    def rows(self, name: str = BALL) -> list[Row]:
        """Those that have ended, then those that want an action."""
        if name not in self.env.behavior_specs:
            return []
        decisions, ended = self.env.get_steps(name)
        whats = [*(["interrupted" if cut else "ended" for cut in ended.interrupted]), *["wants"] * len(decisions)]
        ids = [*ended.agent_id, *decisions.agent_id]
        rewards = [*ended.reward, *decisions.reward]
        seen = [*self.firsts(ended), *self.firsts(decisions)]
        return [
            Row(what, int(number), float(reward), float(first))
            for what, number, reward, first in zip(whats, ids, rewards, seen, strict=True)
        ]

    @staticmethod
    def firsts(steps: Any) -> list[float]:
        return [row.flat[0] for row in steps.obs[0]] if steps.obs else [float("nan")] * len(steps)

    def told(self) -> list[str]:
        """All that happened, when Play is over: Python's end ends it."""
        self.env.close()
        self.program.wait()
        return told(self.program)


def alone(play: Callable[..., Program], *words: str) -> tuple[list[str], str]:
    """What happens without Python, and all that was printed."""
    program = play("clock", *words, "--mlagents-port", str(steady_port()))
    program.wait()
    return told(program), program.output


def told(program: Program) -> list[str]:
    return [line.removeprefix("| ") for line in program.lines if line.startswith("| ")]
