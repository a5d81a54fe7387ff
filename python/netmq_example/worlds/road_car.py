"""The road's car as a simulation, to be driven step by step through an environment. In C# it is RoadCar.cs.

    Simulator(RoadCar())        what netmq_example.scene.simulator connects to an environment, NetMQExample/Car-v0

It sees where it is relative to the road: five numbers. Both sides give the same numbers to the last bit, as road.py
does. It needs numpy and gymnasium.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from gymnasium.spaces import Box

from netmq_example.messages import MessageError
from netmq_example.scene.simulation import Simulation
from netmq_example.worlds.road import HALF_WIDTH, STEP_SECONDS, Car, DrawnCamera, Road

# So many points of the road ahead, some 9 m, it sees where the road goes.
AHEAD = 60


class RoadCar(Simulation):
    """The reward is how many metres it came along the road; beside the road the episode ends. An action is to steer,
    -1, left, to 1, right, and throttle above 0, brake below. A state is the number of a point of the road.
    """

    name = "Car"
    dt = STEP_SECONDS
    size = 1
    observation = Box(-2, 2, (5,), np.float32)
    action = Box(-1, 1, (2,), np.float32)

    def __init__(self) -> None:
        self.road = Road()
        self.car = Car.on(self.road)
        self.camera = DrawnCamera(self.road)
        self.metres = 0.0

    def reset(self, rng: Iterator[float], options: dict[str, Any], state: list[float]) -> None:
        at = state[0] if state else next(rng) * len(self.road.points)
        if not 0 <= at < len(self.road.points):
            raise MessageError("bad-state", f"the road has the points 0 to {len(self.road.points) - 1}")
        self.car = Car.on(self.road, int(at))
        self.metres = 0.0

    def apply(self, action: Any) -> None:
        steer, pedal = float(action[0]), float(action[1])
        self.car.step(max(0.0, pedal), max(0.0, -pedal), steer)
        self.metres += self.progress()

    def observe(self) -> Any:
        car = self.car
        at, _ = self.road.nearest(car.x, car.y)
        x, y = self.road.points[at]
        to_x, to_y = self.along(at)
        far_x, far_y = self.along(at + AHEAD)
        # To the right of the road's direction is (to_y, -to_x).
        off = ((car.x - x) * to_y - (car.y - y) * to_x) / HALF_WIDTH
        across = car.ahead_x * to_y - car.ahead_y * to_x
        along = car.ahead_x * to_x + car.ahead_y * to_y
        return np.array([off, across, along, car.speed / 20, far_x * to_y - far_y * to_x], np.float32)

    def reward_and_end(self) -> dict[str, Any]:
        off_the_road = self.road.nearest(self.car.x, self.car.y)[1] > HALF_WIDTH
        return {"reward": self.progress(), "terminated": off_the_road, "truncated": False, "metres": self.metres}

    def render(self) -> Any:
        # Lesson 08's pictures have the lowest row first, Gymnasium's the highest.
        return self.camera.draw(self.car, 0)[::-1]

    def progress(self) -> float:
        to_x, to_y = self.along(self.road.nearest(self.car.x, self.car.y)[0])
        return (self.car.ahead_x * to_x + self.car.ahead_y * to_y) * self.car.speed * STEP_SECONDS

    def along(self, at: int) -> tuple[float, float]:
        return self.road.along(at % len(self.road.points))
