"""Poles that begin by numbers of their own, whatever their seed is: the same episodes behind any interface.

python -m netmq_example.mlagents_learn config.yaml --env=tests/lessons/mlagents_poles.py
"""

import os
import random
import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parents[2] / "python")]

from netmq_example.scene import Scene, run  # noqa: E402
from netmq_example.worlds.cart_pole import DT, CartPole  # noqa: E402

MOST_STEPS = 200


class Pole(CartPole):
    number = episodes = steps = 0

    def on_reset(self):
        draw = random.Random(1000 * self.number + self.episodes)
        self.state = [draw.uniform(-0.05, 0.05) for _ in range(4)]
        self.episodes += 1
        self.steps = 0
        super().on_reset()

    def on_stepped(self):
        super().on_stepped()
        self.steps += 1
        self.truncated = self.steps == MOST_STEPS and not self.terminated


def poles():
    made = [Pole("pole") for _ in range(int(os.environ.get("POLES", "4")))]
    for number, pole in enumerate(made):
        pole.number = number
    return made


if __name__ == "__main__":
    run(Scene("Pole", poles(), DT))
