"""Three hunters, two rabbits, and a meadow with a fence: an example of a Scene with a world of its own.

    run(Pursuit())          an action is 0, to rest, or 1 to 4, to run left, right, down or up

Rabbits are faster, so hunters must drive them into a corner. A hunter who runs tires, and one without energy is out; a
rabbit that is caught is out as well. The game ends when all rabbits are caught, or no hunter is left. All move at once:
a player remembers in on_action what it wants, and the world moves them in its on_tick. C# and Python give the same
numbers to the last bit: there is nothing but plus, minus, times, divide and square root. In C# it is Pursuit.cs.
"""

import math
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Discrete

from netmq_example.scene.agent import Agent
from netmq_example.scene.scene import Scene
from netmq_example.wire.split_mix import Draws

NAMES = ["hunter_0", "hunter_1", "hunter_2", "rabbit_0", "rabbit_1"]
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


class Player(Agent):
    """It sees its own place and energy; then of each of the others, in the order of the names, where it is from here,
    and 1 as long as it is in the game.
    """

    observation = Box(-2, 2, (3 * len(NAMES),), np.float32)
    action = Discrete(len(WAYS))

    def __init__(self, world: "Pursuit", name: str) -> None:
        super().__init__(name)
        self.world = world
        self.kind = name[:6]
        self.x = self.y = self.earned = 0.0
        self.energy = 1.0
        self.lives = False
        self.placed = False
        # Before its first action it has none, and stays.
        self.way: int | None = None

    def on_reset(self) -> None:
        # A player that begins anew while the others go on has no place from the world.
        if not self.placed:
            self.place(self.rng)
        self.placed = False

    def place(self, rng: Draws) -> None:
        self.x, self.y = 2 * rng() - 1, 2 * rng() - 1
        self.energy = 1.0
        self.lives = self.placed = True
        self.way = None

    def on_action(self, action: Any) -> None:
        self.way = int(action)

    def move(self) -> None:
        if self.way is None:
            return
        right, up = WAYS[self.way]
        far = RUN[self.kind]
        self.x, self.y = (min(1.0, max(-1.0, at + way * far)) for at, way in ((self.x, right), (self.y, up)))
        self.earned = 0.01
        if self.kind == "hunter":
            self.earned = -0.01
            self.energy = max(0.0, self.energy - (RUNNING if self.way else RESTING))

    def observe(self) -> Any:
        numbers = [self.x, self.y, self.energy]
        for other in self.world.players:
            if other is not self:
                numbers += [other.x - self.x, other.y - self.y, float(other.lives)]
        return np.array(numbers, np.float32)


class Pursuit(Scene):
    def __init__(self) -> None:
        self.players = [Player(self, name) for name in NAMES]
        super().__init__("Pursuit", self.players, dt=0.1)

    def on_reset(self, rng: Draws, options: dict[str, Any]) -> None:
        for player in self.players:
            player.place(rng)

    def living(self, kind: str) -> list[Player]:
        return [player for player in self.players if player.lives and player.kind == kind]

    def on_tick(self, dt: float) -> None:
        players = [player for player in self.players if player.lives]
        for player in players:
            player.move()
        gone = [hunter for hunter in self.living("hunter") if hunter.energy <= 0]
        for rabbit in self.living("rabbit"):
            near = [hunter for hunter in self.living("hunter") if distance(hunter, rabbit) < REACH]
            for hunter in near:
                hunter.earned += 10 / len(near)
            if near:
                rabbit.earned = -10.0
                gone.append(rabbit)
                self.send_info({"caught": rabbit.name, "by": near[0].name})
        for player in gone:
            player.lives = False
        over = not self.living("hunter") or not self.living("rabbit")
        for player in players:
            player.reward += player.earned
            player.earned = 0.0
            player.terminated = over or not player.lives

    def render(self) -> Any:
        picture = np.full((SIZE, SIZE, 3), (90, 140, 70), np.uint8)
        for player in self.players:
            if player.lives:
                x, y = (int((1 + number) * (SIZE - 1) / 2) for number in (player.x, player.y))
                row = SIZE - 1 - y
                picture[max(0, row - 4) : row + 5, max(0, x - 4) : x + 5] = COLOURS[player.kind]
        return picture


def distance(one: Player, other: Player) -> float:
    x, y = one.x - other.x, one.y - other.y
    return math.sqrt(x * x + y * y)
