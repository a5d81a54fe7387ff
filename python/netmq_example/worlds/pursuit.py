"""Three hunters, two rabbits, and a meadow with a fence: an example of an AgentSimulation.

    AgentSimulator(Pursuit())          an action is 0, to rest, or 1 to 4, to run left, right, down or up

Rabbits are faster, so hunters must drive them into a corner. A hunter who runs tires, and one without energy is out; a
rabbit that is caught is out as well. The game ends when all rabbits are caught, or no hunter is left. C# and Python
give the same numbers to the last bit: there is nothing but plus, minus, times, divide and square root. In C# it is
Pursuit.cs.
"""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Discrete

from netmq_example.scene.simulation import AgentSimulation

# The world goes from -1 to 1, both ways; in one step a hunter comes so far, and a rabbit.
RUN = {"hunter": 0.05, "rabbit": 0.06}
# Nearer than this a rabbit is caught.
REACH = 0.1
# The energy that a step costs a hunter; it begins with 1.
RUNNING = 0.03
RESTING = 0.01
# To the right, and up, for each action.
WAYS = [(0, 0), (-1, 0), (1, 0), (0, -1), (0, 1)]
# Of the picture, in pixels.
SIZE = 200
COLOURS = {"hunter": (180, 40, 40), "rabbit": (240, 240, 240)}


class Pursuit(AgentSimulation):
    """An agent sees its own place and energy; then of each of the others, in the order of the names, where it is from
    here, and 1 as long as it is in the game.
    """

    name = "Pursuit"
    dt = 0.1

    def __init__(self) -> None:
        super().__init__()
        names = ["hunter_0", "hunter_1", "hunter_2", "rabbit_0", "rabbit_1"]
        seen = Box(-2, 2, (3 * len(names),), np.float32)
        self.agents = {name: (seen, Discrete(len(WAYS))) for name in names}
        self.place = dict.fromkeys(names, (0.0, 0.0))
        self.energy = dict.fromkeys(names, 1.0)
        self.reward = dict.fromkeys(names, 0.0)
        self.living: list[str] = []
        self.gone: list[str] = []

    def reset(self, rng: Iterator[float], options: dict[str, Any]) -> None:
        for name in self.agents:
            self.place[name] = (2 * next(rng) - 1, 2 * next(rng) - 1)
            self.energy[name] = 1.0
            self.reward[name] = 0.0
        self.living = list(self.agents)
        self.gone = []

    def apply(self, actions: dict[str, Any]) -> None:
        for name, action in actions.items():
            self.move(name, *WAYS[action])
            self.reward[name] = 0.01 if name.startswith("rabbit") else -0.01
            if name.startswith("hunter"):
                self.energy[name] = max(0.0, self.energy[name] - (RUNNING if action else RESTING))
        self.gone = [name for name in self.hunters() if self.energy[name] <= 0]
        for rabbit in self.rabbits():
            near = [name for name in self.hunters() if self.distance(name, rabbit) < REACH]
            for hunter in near:
                self.reward[hunter] += 10 / len(near)
            if near:
                self.reward[rabbit] = -10.0
                self.gone.append(rabbit)
                self.infos.send("", {"caught": rabbit, "by": near[0]})
        self.living = [name for name in self.living if name not in self.gone]

    def move(self, name: str, right: int, up: int) -> None:
        x, y = self.place[name]
        far = RUN[name[:6]]
        self.place[name] = (min(1.0, max(-1.0, x + right * far)), min(1.0, max(-1.0, y + up * far)))

    def distance(self, one: str, other: str) -> float:
        x, y = (a - b for a, b in zip(self.place[one], self.place[other], strict=True))
        return math.sqrt(x * x + y * y)

    def hunters(self) -> list[str]:
        return [name for name in self.living if name.startswith("hunter")]

    def rabbits(self) -> list[str]:
        return [name for name in self.living if name.startswith("rabbit")]

    def observe(self, agent: str) -> Any:
        x, y = self.place[agent]
        numbers = [x, y, self.energy[agent]]
        for name, (far, high) in self.place.items():
            if name != agent:
                numbers += [far - x, high - y, float(name in self.living)]
        return np.array(numbers, np.float32)

    def reward_and_end(self, agent: str) -> dict[str, Any]:
        over = agent in self.gone or not self.hunters() or not self.rabbits()
        return {"reward": self.reward[agent], "terminated": over, "truncated": False}

    def render(self) -> Any:
        picture = np.full((SIZE, SIZE, 3), (90, 140, 70), np.uint8)
        for name in self.living:
            x, y = (int((1 + number) * (SIZE - 1) / 2) for number in self.place[name])
            row = SIZE - 1 - y
            picture[max(0, row - 4) : row + 5, max(0, x - 4) : x + 5] = COLOURS[name[:6]]
        return picture
