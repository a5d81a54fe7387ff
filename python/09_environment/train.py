"""Lesson 09, training: five numbers learn to balance a pole, with nothing but numpy.

    python python/09_environment/train.py                              waits for a simulator: press Play
    python python/09_environment/train.py --launch dotnet run --project csharp-console -- 9
    python python/09_environment/train.py --plot learning_curve.svg    draws what it has learned when; needs matplotlib

How it learns stands in cross_entropy.py. The same --seed gives the same numbers. The guide's page has what it takes to
train with Stable-Baselines3.
"""

import argparse
import importlib.util
import sys
from pathlib import Path
from typing import Any

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example.errors import Error
from netmq_example.extras import importing
from netmq_example.program import run, server_endpoint, whole

with importing("gymnasium; pip install gymnasium, or let kit.py run 9 do it", stopped="stopped"):
    import gymnasium

    import netmq_example.envs.gym_env  # noqa: F401, it registers the environments.
    from netmq_example.extras import pip_install
    from netmq_example.messages import MessageError
    from netmq_example.worlds.cross_entropy import GOAL, STEPS, play, train


def figure(path: str) -> str:
    """Whether it can be drawn is to be known before the training, and not after it."""
    if not importlib.util.find_spec("matplotlib"):
        raise argparse.ArgumentTypeError(f"it needs matplotlib: {pip_install('matplotlib')}")
    if not Path(path).absolute().parent.is_dir() or Path(path).is_dir():
        raise argparse.ArgumentTypeError(f"cannot write '{path}': give a file in a folder that there is")
    return path


def plot(means: list[float], goal: float, most: float, path: str) -> None:
    import matplotlib

    # The same picture from the same numbers: without a date, and with names that are not drawn by chance.
    matplotlib.use("svg")
    matplotlib.rcParams |= {"svg.hashsalt": "netmq-example", "svg.fonttype": "none"}
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(8.4, 3.6), layout="constrained")
    axes.plot(range(1, len(means) + 1), means, marker="o", color="#0550ae", label="mean of a generation")
    axes.axhline(goal, color="#8c959f", linestyle="--", label="good enough")
    # A little more than the most, or else its point is cut in half.
    axes.set(xlabel="generation", ylabel="steps until the pole falls", ylim=(0, 1.05 * most))
    axes.legend()
    figure.savefig(path, format="svg", metadata={"Date": None})


def main() -> None:
    parser = argparse.ArgumentParser(description="Learns to balance a pole.")
    place = "tcp://127.0.0.1:5559"
    parser.add_argument("--endpoint", type=server_endpoint(place), help=f"where simulators come to; {place}")
    parser.add_argument("--seed", type=whole, default=0, help="the same seed gives the same numbers")
    parser.add_argument("--generations", type=whole, default=50, help="how many at the most")
    parser.add_argument("--plot", type=figure, metavar="FILE", help="draw the learning curve as SVG")
    parser.add_argument("--launch", nargs="+", metavar="WORD", help="a simulator and its words, and nothing after them")
    # By hand: argparse would take the simulator's own words, such as --, for its own.
    at = sys.argv.index("--launch") if "--launch" in sys.argv[1:-1] else len(sys.argv)
    options = parser.parse_args(sys.argv[1:at])
    launch = sys.argv[at + 1 :] or options.launch
    where: dict[str, Any] = {"endpoint": options.endpoint or "", "launch": launch}
    try:
        with gymnasium.make("NetMQExample/CartPole-v0", max_episode_steps=STEPS, **where) as env:
            means = train(lambda episodes: [play(env, *each) for each in episodes], options.seed, options.generations)
        if options.plot:
            plot(means, GOAL, STEPS, options.plot)
    except (OSError, MessageError, ValueError) as error:
        raise Error(str(error)) from None
    if max(means, default=0) < GOAL:
        raise Error(f"no generation reached {GOAL} of {STEPS}; try another --seed, or more --generations")


if __name__ == "__main__":
    run(main, stopped="stopped")
