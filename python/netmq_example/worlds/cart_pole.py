"""A pole on a cart that is pushed left or right: an example of an Agent in code.

    run(Scene("CartPole", [CartPole()], DT))        an action is 0, left, or 1, right; seen are the cart's place,
                                                    its speed, and the angle and turning of the pole

Lengths are in metres, angles in radians, forces in newtons, masses in kilograms. The equations are those of Gymnasium's
CartPole-v1 (Barto, Sutton and Anderson, 1983; Florian, 2007): from the same state, the same actions lead to the same
states. Sine and cosine differ in their last bit from one system to the next, so two systems agree to many digits and
not to all. In C# it is CartPole.cs.
"""

import math
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Discrete

from netmq_example.messages import MessageError
from netmq_example.scene.agent import Agent

# Seconds of a step.
DT = 0.02
GRAVITY = 9.8
FORCE = 10.0
CART_MASS = 1.0
POLE_MASS = 0.1
HALF_LENGTH = 0.5
# The episode is over when the cart leaves the track, or the pole falls: 12 degrees.
TRACK = 2.4
FALL = 12 * 2 * math.pi / 360
# Of the picture, in pixels, and how many of them are a metre.
WIDTH, HEIGHT = 300, 200
SCALE = 60


# Twice as far as an episode goes, so that its last observation is in the space as well. Any finite speed: of an
# infinite one Gymnasium's checker warns.
ANY_SPEED = np.finfo(np.float32).max
MOST = np.array([2 * TRACK, ANY_SPEED, 2 * FALL, ANY_SPEED], np.float32)


class CartPole(Agent):
    """`low` and `high` are options of a reset: between them lie the four numbers in which an episode begins."""

    state_size = 4
    observation = Box(-MOST, MOST, dtype=np.float32)
    action = Discrete(2)
    place = speed = angle = turning = push = 0.0

    def on_reset(self) -> None:
        low, high = self.options.get("low", -0.05), self.options.get("high", 0.05)
        if isinstance(low, str) or isinstance(high, str):
            raise MessageError("bad-option", "low and high are numbers, between which an episode begins")
        drawn = [low + (high - low) * self.rng() for _ in range(4)]
        self.place, self.speed, self.angle, self.turning = self.state or drawn
        self.push = 0.0

    def on_action(self, action: Any) -> None:
        self.push = FORCE if action == 1 else -FORCE

    def on_tick(self, dt: float) -> None:
        sine, cosine = math.sin(self.angle), math.cos(self.angle)
        mass = CART_MASS + POLE_MASS
        push = self.push + POLE_MASS * HALF_LENGTH * (self.turning * self.turning) * sine
        forward = push / mass
        inertia = HALF_LENGTH * (4 / 3 - POLE_MASS * (cosine * cosine) / mass)
        around = (GRAVITY * sine - cosine * forward) / inertia
        forward -= POLE_MASS * HALF_LENGTH * around * cosine / mass
        self.place += dt * self.speed
        self.speed += dt * forward
        self.angle += dt * self.turning
        self.turning += dt * around

    def on_stepped(self) -> None:
        self.reward += 1.0
        self.terminated = abs(self.place) > TRACK or abs(self.angle) > FALL

    def observe(self) -> Any:
        return np.array([self.place, self.speed, self.angle, self.turning], np.float32)

    def render(self) -> Any:
        picture = np.full((HEIGHT, WIDTH, 3), 255, np.uint8)

        def fill(x: float, y: float, width: int, height: int, colour: tuple[int, int, int]) -> None:
            """A rectangle around a place in pixels, y upwards; what is outside is left out."""
            left, top = int(x) - width // 2, HEIGHT - int(y) - height // 2
            picture[max(0, top) : max(0, top + height), max(0, left) : max(0, left + width)] = colour

        middle = WIDTH / 2 + SCALE * self.place
        fill(WIDTH / 2, 50, WIDTH, 2, (0, 0, 0))
        fill(middle, 50, 50, 30, (40, 60, 90))
        for along in range(2 * SCALE):
            fill(middle + along * math.sin(self.angle), 60 + along * math.cos(self.angle), 6, 6, (200, 140, 80))
        return picture
