"""Lesson 11, the world: a car that collects coins on a field of 10 by 10 m. In C#: CoinCar.cs.

Its fields say what is seen of them. At home your own agent takes its place.
"""

from typing import Annotated, Any

import numpy as np

from netmq_example.simulation.scene import Agent, Obs

FIELD, COINS, REACH, SPEED = 10.0, 3, 0.5, 3.0
GRASS, COIN, CAR = (40, 80, 40), (240, 200, 40), (200, 30, 30)


class CoinCar(Agent):
    place: Annotated[Any, Obs()]
    coins: Annotated[list[Any], Obs()]
    left: Annotated[int, Obs()] = 0
    says: Annotated[str, Obs()] = ""
    push: Annotated[Any, Obs(".last.push")]
    boost: Annotated[int, Obs(".last.boost")] = 0
    picture: Annotated[Any, Obs(".camera")]

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.x = self.y = 0.0
        self.spots, self.steps = list[tuple[float, float]](), 0

    def on_reset(self) -> None:
        self.x = self.y = FIELD / 2
        self.spots = [(1 + 8 * next(self.chance), 1 + 8 * next(self.chance)) for _ in range(COINS)]
        self.push, self.boost, self.says, self.steps = np.zeros(2, np.float32), 0, "", 0
        self.look()

    def on_action(self, action: Any) -> None:
        self.push, self.boost = action["push"], action["boost"]
        self.steps += 1

    def on_tick(self, dt: float) -> None:
        metres = SPEED * (1 + self.boost) * dt
        self.x, self.y = (
            min(FIELD, max(0.0, at + float(part) * metres))
            for at, part in zip((self.x, self.y), self.push, strict=True)
        )
        self.reward -= 0.01
        for spot in [(x, y) for x, y in self.spots if self.near(x, y)]:
            self.spots.remove(spot)
            self.reward += 1
            self.says = f"coin {COINS - len(self.spots)} after {self.steps} steps"
            self.infos.append(self.says)
        self.terminated = not self.spots
        self.look()

    def near(self, x: float, y: float) -> bool:
        return (x - self.x) * (x - self.x) + (y - self.y) * (y - self.y) < REACH * REACH

    def look(self) -> None:
        """What the fields have from now on."""
        self.place, self.left = np.array([self.x, self.y], np.float32), len(self.spots)
        self.coins = [np.array(spot, np.float32) for spot in self.spots]
        self.picture = self.draw()

    def draw(self) -> Any:
        """The field from above, uint8 [24, 32, 3], the highest row first."""
        picture = np.full((24, 32, 3), GRASS, np.uint8)
        for (x, y), colour in [*((spot, COIN) for spot in self.spots), ((self.x, self.y), CAR)]:
            row, column = int((FIELD - y) / FIELD * 22), int(x / FIELD * 30)
            picture[row : row + 2, column : column + 2] = colour
        return picture
