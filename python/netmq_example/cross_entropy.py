"""Lesson 09, how it learns: the cross-entropy method (Rubinstein, 1999).

Draw some policies by chance, keep the best, and draw the next ones around those. A policy pushes to the right when its
four weights times the observation, and its bias, are above 0.
"""

import time
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np

STEPS, POLICIES, BEST, TRIALS, GOAL = 200, 16, 4, 5, 195
# A policy, and the seed from which it is played: whoever plays it, the number is the same.
Episode = tuple[Any, int]


def play(env: gymnasium.Env[Any, Any], policy: Any, seed: int) -> int:
    """How many steps the pole stays up."""
    (seen, _), steps, over = env.reset(seed=seed), 0, False
    while not over:
        seen, _, terminated, truncated, info = env.step(int(policy[:4] @ seen + policy[4] > 0))
        steps, over = steps + 1, terminated or truncated
        if "lost" in info:
            raise ConnectionError(info["lost"])
    return steps


def train(play_all: Callable[[list[Episode]], list[int]], seed: int, generations: int) -> list[float]:
    """What the middle of each generation's best reaches, until it is good enough."""
    random, means, total, begin = np.random.default_rng(seed), list[float](), 0, time.monotonic()
    middle, spread = np.zeros(5), np.ones(5)
    while len(means) < generations and max(means, default=0) < GOAL:
        policies = middle + spread * random.standard_normal((POLICIES, 5))
        # All of a generation begin with the same pole, so that luck decides less.
        start = int(random.integers(2**31))
        returns = np.array(play_all([(policy, start) for policy in policies]))
        best = policies[np.argsort(returns, kind="stable")[-BEST:]]
        # Never quite sure of itself: without the 0.1 it stops to look around too early.
        middle, spread = best.mean(axis=0), best.std(axis=0) + 0.1
        trials = play_all([(middle, int(random.integers(2**31))) for _ in range(TRIALS)])
        means.append(sum(trials) / TRIALS)
        total += int(returns.sum()) + sum(trials)
        rate = total / (time.monotonic() - begin)
        print(
            f"generation {len(means)}: mean {means[-1]:.1f} of {STEPS}, {total:,} steps, {rate:,.0f} a second",
            flush=True,
        )
    print(f"policy: {' '.join(f'{number:.6f}' for number in middle)}")
    return means
