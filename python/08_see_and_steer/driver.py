"""Lesson 08, the driver: sees where the road is, aims at a point in its middle, and keeps a speed.

It needs no training: grass is greener than it is red or blue, and a road is not. That is a difference of colours, so it
holds in sun and shadow, through JPEG, and for pictures of any size. How it steers is known as pure pursuit (Coulter,
1992): along the circle that leads from the car to the point.

It needs numpy. Your own camera's height, tilt and angle belong into the constants.
"""

import math
from typing import Any

import numpy as np

# A camera 1.5 m above the ground, tilted down by 16.26 degrees, 60 degrees from its upper edge to its lower one.
ABOVE = 1.5
SINE = 0.28
COSINE = 0.96
FOCAL = 3**0.5 / 2
# The curvature of the car's path at full lock, in 1/m: the tangent of 22 degrees, over 2.5 m from axle to axle.
FULL_LOCK = 0.16
# It looks at the ground between these distances, in metres, and drives at this speed, in m/s.
NEAR = 5.0
FAR = 9.0
SPEED = 8.0
# Of the values of an action those that are no numbers.
WORDS = (str, bool)


def main_camera(seen: dict[str, Any]) -> Any:
    """The picture to drive by: the middle camera's, or else the first one's."""
    return seen.get("center", next(iter(seen.values())))


def as_action(told: Any) -> dict[str, Any]:
    """The three numbers or the dict that a driver returns, as the values of a message."""
    if not isinstance(told, dict):
        try:
            throttle, brake, steer = told
        except (TypeError, ValueError):
            raise ValueError(f"drive returns throttle, brake, steer, or a dict with them, not {told!r:.60}") from None
        told = {"throttle": throttle, "brake": brake, "steer": steer}
    for name in ("throttle", "brake", "steer"):
        if told.get(name) is None or isinstance(told[name], WORDS):
            raise ValueError(f"the dict that drive returns has no number {name!r}")
    # A number may be numpy's or PyTorch's.
    values = {name: value if isinstance(value, WORDS) else float(value) for name, value in told.items()}
    for name, value in values.items():
        if isinstance(value, float) and not math.isfinite(value):
            raise ValueError(f"drive returns {name} {value}, which is not finite")
    return values


def is_road(pixels: Any) -> Any:
    """Which pixels are not grass: as shares of a pixel's light, so that it may be dark or bright."""
    red, green, blue = (pixels[..., i].astype(np.float32) for i in range(3))
    return 2 * green - red - blue < 0.1 * (red + green + blue)


def row_at(distance: float, height: int) -> int:
    """The row of a picture that shows the ground so far ahead, counted from the top."""
    down = (ABOVE * COSINE - distance * SINE) / (distance * COSINE + ABOVE * SINE)
    return round(height * (0.5 + FOCAL * down))


def middle(picture: Any) -> tuple[float, float] | None:
    """The middle of the road as metres ahead and to the right; None where no road is to be seen."""
    height, width = picture.shape[:2]
    first, last = row_at(FAR, height), row_at(NEAR, height)
    road = is_road(picture[first:last])
    found = road.sum(axis=1)
    seen = found > width / 50
    if not seen.any():
        return None
    columns = (road @ np.arange(width, dtype=np.float32))[seen] / found[seen] + 0.5 - width / 2
    down = (np.arange(first, last)[seen] + 0.5 - height / 2) / height / FOCAL
    # From the camera along the ray through a pixel to the ground.
    far = ABOVE / (SINE + down * COSINE)
    return float((far * (COSINE - down * SINE)).mean()), float((far * columns / height / FOCAL).mean())


def follow_road(picture: Any, speed: float) -> tuple[float, float, float]:
    """throttle, brake and steer for a picture, uint8 [height, width, 3] with its top row first, and a speed in m/s."""
    point = middle(picture)
    if point is None:
        return 0.0, 1.0, 0.0
    ahead, right = point
    steer = 2 * right / (ahead * ahead + right * right) / FULL_LOCK
    return keep_speed(speed, steer)


def keep_speed(speed: float, steer: float) -> tuple[float, float, float]:
    """Full throttle 1 m/s below the speed that is wanted, full brake 4 m/s above it."""
    throttle = min(1.0, max(0.0, SPEED + 0.4 - speed))
    brake = min(1.0, max(0.0, (speed - SPEED - 1) / 3))
    # Not min and max: NaN, which is no number, would become a number by them.
    return throttle, brake, float(np.clip(steer, -1, 1))
