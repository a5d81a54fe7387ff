"""A car, a closed road, and a drawn camera that looks at it: a world for pictures and driving that needs only numpy.

    road = Road()
    car, camera = Car.on(road), DrawnCamera(road)
    car.step(throttle=1.0, brake=0.0, steer=-0.2)           0.02 s later
    picture = camera.draw(car, number=1)                    uint8 [240, 320, 3], the lowest row first

Lengths are in metres, x to the right and y forward as seen from above; time is in seconds, speed in metres a second.
In C# they are Road.cs, Car.cs and DrawnCamera.cs. Both sides give the same numbers to the last bit, because they only
add, subtract, multiply, divide and take square roots of float64: sine and cosine differ from one system to the next.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from netmq_example import arguments, check

STEP_SECONDS = 0.02
# A picture's size in pixels.
WIDTH = 320
HEIGHT = 240
# The road goes through these points, and back from the last to the first.
CORNERS = [(20, 14), (52, 12), (92, 16), (110, 40), (92, 72), (66, 72), (50, 78), (32, 82), (10, 70), (12, 44)]
# Points of the curve from one corner to the next.
SAMPLES = 200
# From the middle of the road to its edge.
HALF_WIDTH = 2.5
# A car 2.5 m from axle to axle, whose wheels turn by 22 degrees: tan(22 deg) / 2.5 m.
CURVATURE = 0.16
# At full throttle and full brake, in m/s^2; and what the air takes of the speed in a second.
ACCELERATION = 4.0
BRAKING = 8.0
DRAG = 0.2
# A camera 1.5 m above the ground, tilted down by 16.26 degrees, 60 degrees from its upper edge to its lower one.
ABOVE = 1.5
SINE = 0.28
COSINE = 0.96
# How far it sees the ground.
FAR = 60.0
# How far to the right of the car's middle each camera is: two as far apart as eyes, three as in Udacity's car.
CAMERAS = {"center": [0.0], "left,right": [-0.075, 0.075], "left,center,right": [-0.8, 0.0, 0.8]}
# The edge of a cell of the ground.
CELL = 0.1
# Red, green and blue.
GRASS = (70, 120, 50)
TARMAC = (90, 90, 95)
PAINT = (230, 230, 225)
SKY = (150, 190, 230)


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
        apart = self.points - (arguments.number("x", x), arguments.number("y", y))
        squares = apart[:, 0] * apart[:, 0] + apart[:, 1] * apart[:, 1]
        at = int(squares.argmin())
        return at, math.sqrt(squares[at])

    def along(self, at: int) -> tuple[float, float]:
        """The direction of the road at a point, of length 1."""
        at = check.count("at", at, least=0, most=len(self.points) - 1)
        x, y = self.points[(at + 1) % len(self.points)] - self.points[at]
        length = math.sqrt(x * x + y * y)
        return float(x / length), float(y / length)


@dataclass
class Car:
    """A kinematic bicycle: it goes where its wheels point. (ahead_x, ahead_y) has length 1 and says where that is."""

    x: float
    y: float
    ahead_x: float
    ahead_y: float
    # Backwards below 0.
    speed: float = 0.0

    @classmethod
    def on(cls, road: Road, at: int = 0) -> "Car":
        """At a point of the road, looking along it."""
        ahead_x, ahead_y = check.instance("road", road, Road).along(at)
        x, y = road.points[at]
        return cls(float(x), float(y), ahead_x, ahead_y)

    def __post_init__(self) -> None:
        for name in ("x", "y", "ahead_x", "ahead_y", "speed"):
            arguments.number(name, getattr(self, name))

    def step(self, throttle: float, brake: float, steer: float) -> None:
        """Drive for STEP_SECONDS. throttle is -1, backwards, to 1, brake 0 to 1, steer -1, left, to 1, right."""
        throttle = arguments.number("throttle", throttle, -1, 1)
        brake = arguments.number("brake", brake, 0, 1)
        steer = arguments.number("steer", steer, -1, 1)
        # The brake acts against the way in which it would roll without it, and ends at a standstill.
        backwards = self.speed + (throttle * ACCELERATION - self.speed * DRAG) * STEP_SECONDS < 0
        held = -brake if backwards else brake
        speed = self.speed + (throttle * ACCELERATION - held * BRAKING - self.speed * DRAG) * STEP_SECONDS
        self.speed = min(0.0, speed) if backwards else max(0.0, speed)
        # Half the angle to turn by; these are the cosine and sine of an angle whose half has this tangent.
        half = self.speed * STEP_SECONDS * steer * CURVATURE / 2
        cosine = (1 - half * half) / (1 + half * half)
        sine = 2 * half / (1 + half * half)
        ahead_x, ahead_y = self.ahead_x, self.ahead_y
        self.ahead_x = ahead_x * cosine + ahead_y * sine
        self.ahead_y = ahead_y * cosine - ahead_x * sine
        self.x += self.ahead_x * self.speed * STEP_SECONDS
        self.y += self.ahead_y * self.speed * STEP_SECONDS


class DrawnCamera:
    """Draws what a camera on the car sees: uint8 [240, 320, 3], red, green and blue, the lowest row first."""

    def __init__(self, road: Road) -> None:
        check.instance("road", road, Road)
        # The ground from above, a byte for each cell: painted road edges, tarmac over them, and dashes.
        self.ground = np.zeros((1000, 1200), np.uint8)
        for radius, colour, every in (HALF_WIDTH, 2, 1), (HALF_WIDTH - 0.2, 1, 1), (0.1, 2, 50):
            reach = int(radius / CELL) + 1
            grid = np.arange(-reach, reach + 1)
            disc = (grid * grid)[:, None] + grid * grid <= radius * radius / CELL / CELL
            for i, (x, y) in enumerate(road.points):
                if every == 1 or i % every < every // 2:
                    left = int(x / CELL) - reach
                    low = int(y / CELL) - reach
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
        """The picture from `right` metres right of the car's middle; the number is 16 squares, a 1 in white."""
        check.instance("car", car, Car)
        number = check.count("number", number, least=0, most=2**53 - 1)
        across = self.right + arguments.number("right", right)
        x = car.x + car.ahead_x * self.ahead + car.ahead_y * across
        y = car.y + car.ahead_y * self.ahead - car.ahead_x * across
        picture = np.empty((HEIGHT, WIDTH, 3), np.uint8)
        columns = (x / CELL).astype(np.int64)
        rows = (y / CELL).astype(np.int64)
        inside = (x >= 0) & (y >= 0) & (columns < self.ground.shape[1]) & (rows < self.ground.shape[0])
        picture[: self.rows] = self.colours[np.where(inside, self.ground[rows * inside, columns * inside], 0)]
        picture[self.rows :] = SKY
        for bit in range(16):
            picture[HEIGHT - 8 :, 8 * bit : 8 * bit + 8] = 255 * (number >> (15 - bit) & 1)
        return picture
