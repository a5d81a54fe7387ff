"""Lesson 12, the world: lesson 08's car drives along its road by itself, seen by two views. In C#: SelfDriving.cs.

Both sides give the same pictures, to the last byte. In a project of yours, your game takes its place.
"""

from typing import Any

import numpy as np

from netmq_example.worlds.road import CURVATURE, GRASS, HEIGHT, TARMAC, WIDTH, Car, DrawnCamera, Road

# It aims at a point of the road that is so many points, some 6 m, ahead, and drives at 8 m/s.
POINTS_AHEAD = 40
METRES_A_SECOND = 8.0
# The map: its scale, and at which pixel the world's corner is.
PIXELS_A_METRE = 2
LEFT_PIXELS = 40
LOW_PIXELS = 20
CAR = (200, 30, 30)


class SelfDriving:
    """A step takes STEP_SECONDS of road.py, 0.02 s."""

    def __init__(self) -> None:
        self.road = Road()
        self.steps = 0
        self.car = Car.on(self.road)
        self.camera = DrawnCamera(self.road)
        self.ground = np.full((HEIGHT, WIDTH, 3), GRASS, np.uint8)
        for x, y in self.road.points:
            square(self.ground, x, y, 4, TARMAC)

    def step(self) -> None:
        car = self.car
        nearest = self.road.nearest(car.x, car.y)[0]
        x, y = self.road.points[(nearest + POINTS_AHEAD) % len(self.road.points)] - (car.x, car.y)
        # Along the circle that leads there.
        steer = 2 * (x * car.ahead_y - y * car.ahead_x) / (x * x + y * y) / CURVATURE
        throttle = min(1.0, max(0.0, METRES_A_SECOND + 0.4 - car.speed))
        car.step(throttle, 0.0, min(1.0, max(-1.0, float(steer))))
        self.steps += 1

    def front(self) -> Any:
        """The picture of a camera on the car, lowest row first, with the number of the step in its upper corner."""
        return self.camera.draw(self.car, self.steps)

    def map(self) -> Any:
        """All of the road from above, and where the car is."""
        picture = self.ground.copy()
        square(picture, self.car.x, self.car.y, 3, CAR)
        return picture


def square(picture: Any, x: float, y: float, half: int, colour: tuple[int, int, int]) -> None:
    column = LEFT_PIXELS + int(x * PIXELS_A_METRE)
    row = LOW_PIXELS + int(y * PIXELS_A_METRE)
    picture[row - half : row + half + 1, column - half : column + half + 1] = colour


def scaled(picture: Any, width: int, height: int) -> Any:
    """Smaller: of each place the nearest pixel."""
    rows = np.arange(height) * picture.shape[0] // height
    columns = np.arange(width) * picture.shape[1] // width
    return np.ascontiguousarray(picture[rows][:, columns])
