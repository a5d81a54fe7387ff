"""A car that collects coins on a field of 10 by 10 m. Its fields say what is seen of it.

    run(Scene("Coins", [CoinCar()], dt=0.1))

An action is {"push": float32 [2] from -1 to 1, "boost": 0 or 1}. Each coin is a reward of 1, each tick costs 0.01, and
with the last coin the episode ends. In C# it is CoinCar.cs, which sees the same to the last byte. It needs numpy.
"""

from typing import Annotated, Any

import numpy as np

import netmq_example.scene.attributes  # noqa: F401, a copy of this world needs it.
from netmq_example.scene.agent import Agent, Obs

FIELD_METRES = 10.0
COINS = 3
REACH_METRES = 0.5
METRES_A_SECOND = 3.0
GRASS, COIN, CAR = (40, 80, 40), (240, 200, 40), (200, 30, 30)


class CoinCar(Agent):
    place: Annotated[Any, Obs()]
    coins: Annotated[list[Any], Obs()]
    left: Annotated[int, Obs()] = 0
    says: Annotated[str, Obs()] = ""
    push: Annotated[Any, Obs(".last.push")]
    boost: Annotated[int, Obs(".last.boost")] = 0
    picture: Annotated[Any, Obs(".camera")]

    def __init__(self, name: str = "agent") -> None:
        super().__init__(name)
        self.x = self.y = 0.0
        self.spots: list[tuple[float, float]] = []
        self.steps = 0

    def on_reset(self) -> None:
        self.x = self.y = FIELD_METRES / 2
        self.spots = [(1 + 8 * self.rng(), 1 + 8 * self.rng()) for _ in range(COINS)]
        self.push = np.zeros(2, np.float32)
        self.boost = 0
        self.says = ""
        self.steps = 0
        self.look()

    def on_action(self, action: Any) -> None:
        self.push = action["push"]
        self.boost = action["boost"]
        self.steps += 1

    def on_tick(self, dt: float) -> None:
        metres = METRES_A_SECOND * (1 + self.boost) * dt
        self.x = on_the_field(self.x + float(self.push[0]) * metres)
        self.y = on_the_field(self.y + float(self.push[1]) * metres)
        self.reward -= 0.01
        for spot in [(x, y) for x, y in self.spots if self.near(x, y)]:
            self.spots.remove(spot)
            self.reward += 1
            self.says = f"coin {COINS - len(self.spots)} after {self.steps} steps"
            self.send_info(self.says)
        self.terminated = not self.spots
        self.look()

    def near(self, x: float, y: float) -> bool:
        return (x - self.x) * (x - self.x) + (y - self.y) * (y - self.y) < REACH_METRES * REACH_METRES

    def look(self) -> None:
        """Set the fields that the observation is read from."""
        self.place = np.array([self.x, self.y], np.float32)
        self.left = len(self.spots)
        self.coins = [np.array(spot, np.float32) for spot in self.spots]
        self.picture = self.draw()

    def draw(self) -> Any:
        """The field from above, uint8 [48, 64, 3], the highest row first."""
        picture = np.full((48, 64, 3), GRASS, np.uint8)
        for (x, y), colour in [*((spot, COIN) for spot in self.spots), ((self.x, self.y), CAR)]:
            row = int((FIELD_METRES - y) / FIELD_METRES * 44)
            column = int(x / FIELD_METRES * 60)
            picture[row : row + 4, column : column + 4] = colour
        return picture


def on_the_field(metres: float) -> float:
    return min(FIELD_METRES, max(0.0, metres))
