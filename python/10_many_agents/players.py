"""Lesson 10, the players: written by hand. Yours are what you train."""

import functools
from typing import Any

import numpy as np

from netmq_example import check
from netmq_example.program import option

LEFT, RIGHT, DOWN, UP = 1, 2, 3, 4
STEPS = 1000


def areas(text: str) -> int:
    """The type of --areas."""
    return option(functools.partial(check.count, most=1024), text, int)


def policy(agent: str, seen: Any) -> int:
    """A rabbit runs from the nearest hunter; a hunter to the nearest rabbit, and rests while that is too far."""
    others = seen[3:].reshape(-1, 3)
    hunter = agent.startswith("hunter")
    # In the order of their names: a hunter sees two hunters first, a rabbit three.
    wanted = [one for one in (others[2:] if hunter else others[:3]) if one[2]]
    x, y, _ = min(wanted, key=lambda one: one[0] ** 2 + one[1] ** 2)
    if hunter and x * x + y * y > 1:
        return 0
    # From something on the right one runs to the left, and so on.
    x, y = (x, y) if hunter else (-x, -y)
    if abs(x) > abs(y):
        return RIGHT if x > 0 else LEFT
    return UP if y > 0 else DOWN


class Game:
    """Hunters and rabbits, from their beginning to the end of the game."""

    def __init__(self, number: int) -> None:
        self.seed = number
        self.steps = 0
        self.caught = 0
        self.lost = ""

    def plays(self, env: Any) -> bool:
        return bool(env.agents)

    def actions(self, env: Any, seen: dict[str, Any]) -> dict[str, int]:
        return {agent: policy(agent, seen[agent]) for agent in env.agents}

    def count(self, terminated: Any, truncated: Any, infos: dict[str, Any]) -> None:
        # Each agent's info has what the game itself says.
        info = next(iter(infos.values()))
        self.steps += 1
        self.caught += sum("caught" in each for each in info.get("env", []))
        self.lost = f", {info['lost']}" if "lost" in info else ""

    def __str__(self) -> str:
        return f"game {self.seed}: {self.steps} steps, {self.caught} of 2 rabbits caught{self.lost}"


def balance(seen: Any) -> Any:
    """Push each cart to where its pole falls."""
    return (seen[:, 2] + seen[:, 3] > 0).astype(np.int64)


def drive(seen: Any) -> Any:
    """Steer each car back to the middle of its road."""
    steer = 2 * seen[:, 4] - seen[:, 0] - 2 * seen[:, 1]
    return np.column_stack([np.clip(steer, -1, 1), np.full(len(seen), 0.4)]).astype(np.float32)


class Crowd:
    """Steps all areas so often. An area resets by itself when its pole falls or its car leaves the road."""

    seed = 1

    def __init__(self, world: str) -> None:
        self.policy = {"CartPole": balance, "Car": drive}[world]
        self.areas = 0
        self.steps = 0
        self.ended = 0
        self.lost = ""

    def plays(self, envs: Any) -> bool:
        self.areas = envs.num_envs
        return self.steps < STEPS

    def actions(self, envs: Any, seen: Any) -> Any:
        return self.policy(seen)

    def count(self, terminated: Any, truncated: Any, infos: dict[str, Any]) -> None:
        self.steps += 1
        self.ended += int((terminated | truncated).sum())
        if "lost" in infos:
            self.lost = f", {infos['lost'][0]}"

    def __str__(self) -> str:
        return f"{self.steps} steps of {self.areas} areas: {self.ended} episodes ended{self.lost}"
