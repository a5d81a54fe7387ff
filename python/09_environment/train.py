"""Lesson 09, training: five numbers learn to balance a pole, with nothing but numpy.

    python python/09_environment/train.py                              waits for a simulator: press Play
    python python/09_environment/train.py --launch dotnet run --project csharp-console -- 9
    python python/09_environment/train.py --plot learning_curve.svg    draws what it has learned when; needs matplotlib

The cross-entropy method (Rubinstein, 1999): draw some policies by chance, keep the best, and draw the next ones
around those. A policy pushes to the right when its four weights times the observation, and its bias, are above 0. The
same --seed gives the same numbers. At home, train with what you like: see the guide's page for Stable-Baselines3.
"""

import argparse
import sys
import time
from typing import Any

import environment  # noqa: F401, it registers the environments.
import gymnasium
import numpy as np
from messages import MessageError

STEPS, POLICIES, BEST, TRIALS, GOAL = 200, 16, 4, 5, 195


def play(env: gymnasium.Env[Any, Any], policy: Any, seed: int) -> int:
    """How many steps the pole stays up."""
    (seen, _), steps, over = env.reset(seed=seed), 0, False
    while not over:
        seen, _, terminated, truncated, info = env.step(int(policy[:4] @ seen + policy[4] > 0))
        steps, over = steps + 1, terminated or truncated
        if "lost" in info:
            raise ConnectionError(info["lost"])
    return steps


def train(env: gymnasium.Env[Any, Any], seed: int, generations: int) -> list[float]:
    """What the middle of each generation's best reaches, until it is good enough."""
    random, means, total, begin = np.random.default_rng(seed), list[float](), 0, time.monotonic()
    middle, spread = np.zeros(5), np.ones(5)
    while len(means) < generations and max(means, default=0) < GOAL:
        policies = middle + spread * random.standard_normal((POLICIES, 5))
        # All of a generation begin with the same pole, so that luck decides less.
        start = int(random.integers(2**31))
        returns = np.array([play(env, policy, start) for policy in policies])
        best = policies[np.argsort(returns, kind="stable")[-BEST:]]
        # Never quite sure of itself: without the 0.1 it stops to look around too early.
        middle, spread = best.mean(axis=0), best.std(axis=0) + 0.1
        trials = [play(env, middle, int(random.integers(2**31))) for _ in range(TRIALS)]
        means.append(sum(trials) / TRIALS)
        total += int(returns.sum()) + sum(trials)
        rate = total / (time.monotonic() - begin)
        print(
            f"generation {len(means)}: mean {means[-1]:.1f} of {STEPS}, {total:,} steps, {rate:,.0f} a second",
            flush=True,
        )
    print(f"policy: {' '.join(f'{number:.6f}' for number in middle)}")
    return means


def plot(means: list[float], path: str) -> None:
    import matplotlib

    # The same picture from the same numbers: without a date, and with names that are not drawn by chance.
    matplotlib.use("svg")
    matplotlib.rcParams |= {"svg.hashsalt": "netmq-example", "svg.fonttype": "none"}
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(8.4, 3.6), layout="constrained")
    axes.plot(range(1, len(means) + 1), means, marker="o", color="#0550ae")
    axes.axhline(GOAL, color="#8c959f", linestyle="--", label="good enough")
    axes.set(xlabel="generation", ylabel="steps until the pole falls", ylim=(0, STEPS))
    axes.legend()
    figure.savefig(path, metadata={"Date": None})


def main() -> None:
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="Learns to balance a pole.")
    parser.add_argument("--endpoint", default="", help="where the simulator comes to; tcp://127.0.0.1:5559")
    parser.add_argument("--seed", type=int, default=0, help="the same seed gives the same numbers")
    parser.add_argument("--generations", type=int, default=50, help="how many at the most")
    parser.add_argument("--plot", metavar="FILE", help="draw the learning curve as SVG")
    parser.add_argument("--launch", nargs=argparse.REMAINDER, default=[], help="a simulator and its words; comes last")
    options = parser.parse_args()
    where = {"endpoint": options.endpoint, "launch": options.launch}
    try:
        with gymnasium.make("NetMQExample/CartPole-v0", max_episode_steps=STEPS, **where) as env:
            means = train(env, options.seed, options.generations)
    except (OSError, MessageError) as error:
        sys.exit(f"gave up: {error}")
    if options.plot:
        plot(means, options.plot)
    sys.exit(None if max(means) >= GOAL else f"gave up: no generation reached {GOAL} of {STEPS}; try another --seed")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped")
