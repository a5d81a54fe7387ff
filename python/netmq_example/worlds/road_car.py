"""The road's car as an agent, to be driven step by step through an environment. In C# it is RoadCar.cs.

    run(Scene("Car", [RoadCar()], STEP_SECONDS))        for an environment such as NetMQExample/Car-v0

It sees where it is relative to the road: five numbers. Both sides give the same numbers to the last bit, as road.py
does. It needs numpy and gymnasium.
"""

from typing import Any

import numpy as np
from gymnasium.spaces import Box

from netmq_example.messages import MessageError
from netmq_example.scene.agent import Agent
from netmq_example.worlds.road import HALF_WIDTH, Car, DrawnCamera, Road

# So many points of the road ahead, some 9 m, it sees where the road goes.
AHEAD = 60


class RoadCar(Agent):
    """The reward is how many metres it came along the road; beside the road the episode ends. An action is to steer,
    -1, left, to 1, right, and throttle above 0, brake below. A state is the number of a point of the road.
    """

    state_size = 1
    observation = Box(-2, 2, (5,), np.float32)
    action = Box(-1, 1, (2,), np.float32)

    def __init__(self, name: str = "agent") -> None:
        super().__init__(name)
        self.road = Road()
        self.car = Car.on(self.road)
        self.camera = DrawnCamera(self.road)
        self.steer = self.pedal = self.metres = 0.0

    def on_reset(self) -> None:
        at = self.state[0] if self.state else self.rng() * len(self.road.points)
        if not 0 <= at < len(self.road.points):
            raise MessageError("bad-state", f"the road has the points 0 to {len(self.road.points) - 1}")
        self.car = Car.on(self.road, int(at))
        self.steer = self.pedal = self.metres = 0.0

    def on_action(self, action: Any) -> None:
        self.steer, self.pedal = float(action[0]), float(action[1])

    def on_tick(self, dt: float) -> None:
        car = self.car
        car.step(max(0.0, self.pedal), max(0.0, -self.pedal), self.steer)
        to_x, to_y = self.along(self.road.nearest(car.x, car.y)[0])
        progress = (car.ahead_x * to_x + car.ahead_y * to_y) * car.speed * dt
        self.metres += progress
        self.reward += progress

    def on_stepped(self) -> None:
        self.info["metres"] = self.metres
        self.terminated = self.road.nearest(self.car.x, self.car.y)[1] > HALF_WIDTH

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

    def render(self) -> Any:
        # Lesson 08's pictures have the lowest row first, Gymnasium's the highest.
        return self.camera.draw(self.car, 0)[::-1]

    def along(self, at: int) -> tuple[float, float]:
        return self.road.along(at % len(self.road.points))
