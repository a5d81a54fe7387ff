"""Training with nothing but numpy: the cross-entropy method finds five numbers that keep CartPole's pole up.

    env = gymnasium.make("NetMQExample/CartPole-v0", max_episode_steps=STEPS)
    means = train(lambda episodes: [play(env, *episode) for episode in episodes], seed=0, generations=50)

It draws some policies by chance, keeps the best, and draws the next ones around those (Rubinstein, *The cross-entropy
method for combinatorial and continuous optimization*, 1999). A policy pushes to the right when its four weights times
the observation, plus its bias, are above 0. It needs gymnasium.
"""

import logging
import time
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np

from netmq_example import arguments, check
from netmq_example.errors import Lost

# Of an episode, at most; and the mean of a generation that is good enough.
STEPS = 200
GOAL = 195
# Of a generation: how many are drawn, how many of them are kept, and how often their middle is tried.
POLICIES = 16
BEST = 4
TRIALS = 5
# A policy, and the seed from which it is played: the number of steps is the same, wherever that is done.
Episode = tuple[Any, int]

log = logging.getLogger("netmq_example.envs")


def play(env: gymnasium.Env[Any, Any], policy: Any, seed: int) -> int:
    """How many steps the pole stays up; Lost if the simulator is."""
    if np.shape(policy) != (5,):
        raise ValueError(f"policy takes five numbers, four weights and a bias, not {policy!r:.40}")
    seen, info = env.reset(seed=seed)
    steps = 0
    over = False
    while not over:
        seen, _, terminated, truncated, info = env.step(int(policy[:4] @ seen + policy[4] > 0))
        if "lost" in info:
            raise Lost(info["lost"])
        steps += 1
        over = terminated or truncated
    return steps


def train(play_all: Callable[[list[Episode]], list[int]], seed: int, generations: int) -> list[float]:
    """The means of the generations, until one is good enough; logs a line for each."""
    arguments.function("play_all", play_all)
    random = np.random.default_rng(check.count("seed", seed, least=0))
    check.count("generations", generations, least=0)
    begin = time.monotonic()
    means: list[float] = []
    total = 0
    middle = np.zeros(5)
    spread = np.ones(5)
    while len(means) < generations and max(means, default=0) < GOAL:
        policies = middle + spread * random.standard_normal((POLICIES, 5))
        # All of a generation begin with the same pole, so that luck decides less.
        start = int(random.integers(2**31))
        returns = np.array(play_all([(policy, start) for policy in policies]))
        best = policies[np.argsort(returns, kind="stable")[-BEST:]]
        middle = best.mean(axis=0)
        # Never quite sure of itself: without the 0.1 it stops to look around too early.
        spread = best.std(axis=0) + 0.1
        trials = play_all([(middle, int(random.integers(2**31))) for _ in range(TRIALS)])
        means.append(sum(trials) / TRIALS)
        total += int(returns.sum()) + sum(trials)
        rate = total / (time.monotonic() - begin)
        reached = f"mean {means[-1]:.1f} of {STEPS}, {total:,} steps, {rate:,.0f} a second"
        log.info("generation %s: %s", len(means), reached)
    log.info("policy: %s", " ".join(f"{number:.6f}" for number in middle))
    return means
