"""Lesson 09, the second world: lesson 08's car on its road, to be driven step by step. In C#: RoadCar.cs.

What it sees is where it is relative to the road. Both sides give the same numbers to the last bit, as world.py does.
At home your own simulation takes its place.
"""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from simulation import Simulation

# The world is lesson 08's.
sys.path += [str(Path(__file__).resolve().parents[1] / folder) for folder in ("05_messages", "08_see_and_steer")]
from messages import MessageError
from world import HALF_WIDTH, STEP, Car, DrawnCamera, Road

# So many points of the road ahead, some 9 m, it sees where the road goes.
AHEAD = 60


class RoadCar(Simulation):
    """The reward is how many metres it came along the road; beside the road the episode ends. An action is to steer,
    -1, left, to 1, right, and throttle above 0, brake below. A state is the number of a point of the road.
    """

    name, dt, size = "Car", STEP, 1
    observation, action = Box(-2, 2, (5,), np.float32), Box(-1, 1, (2,), np.float32)

    def __init__(self) -> None:
        self.road = Road()
        self.car, self.camera, self.metres = Car.on(self.road), DrawnCamera(self.road), 0.0

    def reset(self, chance: Iterator[float], options: dict[str, Any], state: list[float]) -> None:
        at = state[0] if state else next(chance) * len(self.road.points)
        if not 0 <= at < len(self.road.points):
            raise MessageError("bad-state", f"the road has the points 0 to {len(self.road.points) - 1}")
        self.car, self.metres = Car.on(self.road, int(at)), 0.0

    def apply(self, action: Any) -> None:
        steer, pedal = float(action[0]), float(action[1])
        self.car.step(max(0.0, pedal), max(0.0, -pedal), steer)
        self.metres += self.progress()

    def observe(self) -> Any:
        car, (at, _) = self.car, self.road.nearest(self.car.x, self.car.y)
        (x, y), (to_x, to_y), (far_x, far_y) = self.road.points[at], self.along(at), self.along(at + AHEAD)
        # To the right of the road's direction is (to_y, -to_x).
        off = ((car.x - x) * to_y - (car.y - y) * to_x) / HALF_WIDTH
        across, along = car.ahead_x * to_y - car.ahead_y * to_x, car.ahead_x * to_x + car.ahead_y * to_y
        return np.array([off, across, along, car.speed / 20, far_x * to_y - far_y * to_x], np.float32)

    def judge(self) -> dict[str, Any]:
        off_the_road = self.road.nearest(self.car.x, self.car.y)[1] > HALF_WIDTH
        return {"reward": self.progress(), "terminated": off_the_road, "truncated": False, "metres": self.metres}

    def render(self) -> Any:
        # Lesson 08's pictures have the lowest row first, Gymnasium's the highest.
        return self.camera.draw(self.car, 0)[::-1]

    def progress(self) -> float:
        to_x, to_y = self.along(self.road.nearest(self.car.x, self.car.y)[0])
        return (self.car.ahead_x * to_x + self.car.ahead_y * to_y) * self.car.speed * STEP

    def along(self, at: int) -> tuple[float, float]:
        """A car that stands on the road looks along it."""
        there = Car.on(self.road, at % len(self.road.points))
        return there.ahead_x, there.ahead_y
