"""Lesson 10, the players: written by hand, and as PettingZoo and Gymnasium play everywhere. At home train yours."""

from collections.abc import Iterator
from typing import Any

import numpy as np

GAMES, STEPS = 10, 1000
LEFT, RIGHT, DOWN, UP = 1, 2, 3, 4


def policy(agent: str, seen: Any) -> int:
    """A rabbit runs from the nearest hunter; a hunter to the nearest rabbit, and rests while that is too far."""
    others, hunter = seen[3:].reshape(-1, 3), agent.startswith("hunter")
    # In the order of their names: a hunter sees two hunters first, a rabbit three.
    wanted = [one for one in (others[2:] if hunter else others[:3]) if one[2]]
    x, y, _ = min(wanted, key=lambda one: one[0] ** 2 + one[1] ** 2)
    if hunter and x * x + y * y > 1:
        return 0
    # From something on the right one runs to the left, and so on.
    x, y = (x, y) if hunter else (-x, -y)
    return (RIGHT if x > 0 else LEFT) if abs(x) > abs(y) else (UP if y > 0 else DOWN)


def play(env: Any) -> Iterator[str]:
    """Game after game, and a line for each."""
    for number in range(1, GAMES + 1):
        seen, infos = env.reset(seed=number)
        steps, caught, lost = 0, 0, ""
        while env.agents:
            seen, _, _, _, infos = env.step({agent: policy(agent, seen[agent]) for agent in env.agents})
            said = next(iter(infos.values()))
            caught += sum("caught" in info for info in said.get("told", {}).get("env", []))
            steps, lost = steps + 1, f", {said['lost']}" if "lost" in said else ""
        yield f"game {number}: {steps} steps, {caught} of 2 rabbits caught{lost}"


def balance(envs: Any) -> Iterator[str]:
    """Push each cart to where its pole falls. What is over begins anew by itself."""
    seen, _ = envs.reset(seed=1)
    ended, lost = 0, ""
    for _ in range(STEPS):
        seen, _, terminated, truncated, infos = envs.step((seen[:, 2] + seen[:, 3] > 0).astype(np.int64))
        ended += int((terminated | truncated).sum())
        lost = f", {infos['lost'][0]}" if "lost" in infos else lost
    yield f"{STEPS} steps of {envs.num_envs} areas: {ended} episodes ended{lost}"
