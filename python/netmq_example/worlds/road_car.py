"""Lesson 09, the second world: lesson 08's car on its road, to be driven step by step. In C#: RoadCar.cs.

What it sees is where it is relative to the road. Both sides give the same numbers to the last bit, as world.py does.
At home your own simulation takes its place.

Lesson 08, the world: a car, a closed road, and a drawn camera that looks at it.

Car and road are the twins of Car.cs and Road.cs, and the camera of DrawnCamera.cs. They give the same numbers to the
last bit, because they only add, subtract, multiply, divide and take square roots of float64: sine and cosine differ
from one system to the next. Lengths are in metres, x to the right and y forward as seen from above; time in seconds.
It needs numpy.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium.spaces import Box

from netmq_example.messages import MessageError
from netmq_example.simulation.simulation import Simulation

STEP = 0.02
WIDTH, HEIGHT = 320, 240
# The road goes through these points, and back from the last to the first.
CORNERS = [(20, 14), (52, 12), (92, 16), (110, 40), (92, 72), (66, 72), (50, 78), (32, 82), (10, 70), (12, 44)]
SAMPLES, HALF_WIDTH = 200, 2.5
# A car 2.5 m from axle to axle, whose wheels turn by 22 degrees: tan(22 deg) / 2.5 m.
CURVATURE, ACCELERATION, BRAKING, DRAG = 0.16, 4.0, 8.0, 0.2
# A camera 1.5 m above the ground, tilted down by 16.26 degrees, 60 degrees from its upper edge to its lower one.
ABOVE, SINE, COSINE, FAR = 1.5, 0.28, 0.96, 60.0
# How far to the right of the car's middle each camera is: two as far apart as eyes, three as in Udacity's car.
CAMERAS = {"center": [0.0], "left,right": [-0.075, 0.075], "left,center,right": [-0.8, 0.0, 0.8]}
CELL, GRASS, TARMAC, PAINT, SKY = 0.1, (70, 120, 50), (90, 90, 95), (230, 230, 225), (150, 190, 230)


class Road:
    """A smooth curve through the corners (Catmull and Rom, 1974), as points some 0.15 m apart."""

    def __init__(self) -> None:
        points = []
        for i in range(len(CORNERS)):
            a, b, c, d = (np.array(CORNERS[(i + k - 1) % len(CORNERS)], np.float64) for k in range(4))
            for k in range(SAMPLES):
                t = k / SAMPLES
                bend = (d - a + (b - c) * 3) * t + (a * 2 - b * 5 + c * 4 - d)
                points.append(((bend * t + (c - a)) * t + b * 2) / 2)
        self.points = np.array(points)

    def nearest(self, x: float, y: float) -> tuple[int, float]:
        """The number of the point that is nearest, and how far away it is."""
        apart = self.points - (x, y)
        squares = apart[:, 0] * apart[:, 0] + apart[:, 1] * apart[:, 1]
        at = int(squares.argmin())
        return at, math.sqrt(squares[at])


@dataclass
class Car:
    """A kinematic bicycle: it goes where its wheels point. (ahead_x, ahead_y) has length 1 and says where that is."""

    x: float
    y: float
    ahead_x: float
    ahead_y: float
    speed: float = 0.0

    @classmethod
    def on(cls, road: Road, at: int = 0) -> "Car":
        """At a point of the road, looking along it."""
        (x, y), (to_x, to_y) = road.points[at], road.points[(at + 1) % len(road.points)]
        length = math.sqrt((to_x - x) * (to_x - x) + (to_y - y) * (to_y - y))
        return cls(float(x), float(y), float((to_x - x) / length), float((to_y - y) / length))

    def step(self, throttle: float, brake: float, steer: float) -> None:
        """Drive for STEP seconds. throttle and brake are 0 to 1, steer -1, left, to 1, right."""
        change = (throttle * ACCELERATION - brake * BRAKING - self.speed * DRAG) * STEP
        self.speed = max(0.0, self.speed + change)
        # Half the angle to turn by; these are the cosine and sine of an angle whose half has this tangent.
        half = self.speed * STEP * steer * CURVATURE / 2
        cosine, sine = (1 - half * half) / (1 + half * half), 2 * half / (1 + half * half)
        ahead_x, ahead_y = self.ahead_x, self.ahead_y
        self.ahead_x = ahead_x * cosine + ahead_y * sine
        self.ahead_y = ahead_y * cosine - ahead_x * sine
        self.x += self.ahead_x * self.speed * STEP
        self.y += self.ahead_y * self.speed * STEP


class DrawnCamera:
    """Draws what a camera on the car sees: uint8 [240, 320, 3], red, green and blue, the lowest row first."""

    def __init__(self, road: Road) -> None:
        # The ground from above, a byte for each cell of 0.1 m: painted road edges, tarmac over them, and dashes.
        self.ground = np.zeros((1000, 1200), np.uint8)
        for radius, colour, every in (HALF_WIDTH, 2, 1), (HALF_WIDTH - 0.2, 1, 1), (0.1, 2, 50):
            reach = int(radius / CELL) + 1
            grid = np.arange(-reach, reach + 1)
            disc = (grid * grid)[:, None] + grid * grid <= radius * radius / CELL / CELL
            for i, (x, y) in enumerate(road.points):
                if every == 1 or i % every < every // 2:
                    left, low = int(x / CELL) - reach, int(y / CELL) - reach
                    self.ground[low : low + 2 * reach + 1, left : left + 2 * reach + 1][disc] = colour
        self.colours = np.array([GRASS, TARMAC, PAINT], np.uint8)
        # Where the ray through each pixel meets the ground: how far ahead, and how far to the right.
        focal = HEIGHT / 2 * math.sqrt(3)
        up = (np.arange(HEIGHT) + 0.5 - HEIGHT / 2) / focal
        falls = SINE - up * COSINE
        self.rows = int((falls * FAR > ABOVE * (COSINE + up * SINE)).sum())
        far = ABOVE / falls[: self.rows]
        self.ahead = (far * (COSINE + up[: self.rows] * SINE))[:, None]
        self.right = far[:, None] * ((np.arange(WIDTH) + 0.5 - WIDTH / 2) / focal)

    def draw(self, car: Car, number: int, right: float = 0.0) -> Any:
        """The picture from `right` metres right of the car's middle; the number is drawn as 16 squares, 1 in white."""
        across = self.right + right
        x = car.x + car.ahead_x * self.ahead + car.ahead_y * across
        y = car.y + car.ahead_y * self.ahead - car.ahead_x * across
        picture = np.empty((HEIGHT, WIDTH, 3), np.uint8)
        columns, rows = (x / CELL).astype(np.int64), (y / CELL).astype(np.int64)
        inside = (x >= 0) & (y >= 0) & (columns < self.ground.shape[1]) & (rows < self.ground.shape[0])
        picture[: self.rows] = self.colours[np.where(inside, self.ground[rows * inside, columns * inside], 0)]
        picture[self.rows :] = SKY
        for bit in range(16):
            picture[HEIGHT - 8 :, 8 * bit : 8 * bit + 8] = 255 * (number >> (15 - bit) & 1)
        return picture


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
