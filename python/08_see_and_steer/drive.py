"""Lesson 08, the drive: the car's side of the lesson in Python, as Drive.cs, DriverClient.cs and Shot.cs are in C#.

client.send(drive.message(…))       pictures, with their number and what the car does
drive.apply(client.receive(…))      driver_client.py; now the action's age is known
drive.step()                        0.02 s later
"""

import time
import uuid
from collections.abc import Callable
from typing import Any

from netmq_example.camera.client import Action
from netmq_example.camera.pictures import encode
from netmq_example.messages import Array, Message
from netmq_example.worlds.road_car import STEP, Car, Road

# Steps without an action, after which the car brakes: half a second.
TIMEOUT_STEPS = 25


class Drive:
    """What the car is told, by whom, and what it does when nobody tells it anything."""

    def __init__(self, road: Road, start: int, log: Callable[[str], object], every: int, lockstep: bool) -> None:
        self.road, self.log, self.every, self.lockstep = road, log, every, lockstep
        self.car, self.run = Car.on(road, start % len(road.points)), uuid.uuid4().hex[:8]
        # The number of steps so far, and so of a picture that is taken now.
        self.frame, self.actions = 0, 0
        self.manual, self._braking, self._waited = False, False, 0
        self._action = Action(0, 0.0, 1.0, 0.0)

    def in_force(self) -> Action:
        """The brake does not unlearn the steering: the road does not end at once."""
        return Action(self._action.frame, 0.0, 1.0, self._action.steer) if self._braking else self._action

    def take_over(self, throttle: float, brake: float, steer: float) -> None:
        """A person drives. Python is still asked, but not followed: that is how a person's driving is recorded."""
        if not self.manual:
            self.log("a person drives")
        self.manual, self._action = True, Action(self.frame, throttle, brake, steer)

    def give_back(self) -> None:
        """Python's next action counts again."""
        if self.manual:
            self.log("Python drives")
        self.manual = False

    def message(self, cameras: str, pictures: list[Any], jpeg: bool) -> Message:
        """The pictures of this moment, with their number and what the car does. Raw ones have the lowest row first."""
        now, frame = self.in_force(), self.frame
        values = {"frame": frame, "run": self.run, "manual": self.manual, "sim_time": frame * STEP}
        values |= {"wall_time": time.time(), "speed": self.car.speed, "throttle": now.throttle, "brake": now.brake}
        values |= {"steer": now.steer, "cameras": cameras, "encoding": "jpeg" if jpeg else "raw", "bottom_up": not jpeg}
        message = Message("frame", frame, values)
        for picture in pictures:
            file = encode(picture[::-1]) if jpeg else b""
            message.arrays.append(
                Array("uint8", (len(file),), file) if jpeg else Array("uint8", picture.shape, picture)
            )
        return message

    def apply(self, newest: Action | None) -> None:
        """Follow an action from the next step on; None if there was none for the last picture."""
        if newest is None:
            self._waited = TIMEOUT_STEPS if self.lockstep else self._waited
            return
        self._waited = 0
        if not self.manual:
            self._action = newest
        if self.every and self.actions % self.every == 0:
            off, speed = self.road.nearest(self.car.x, self.car.y)[1], self.car.speed
            timing = f"frame {newest.frame}: age {self.frame - newest.frame}, {newest.milliseconds:.1f} ms"
            self.log(f"{timing}; steer {newest.steer:.2f}, speed {speed:.1f} m/s, {off:.1f} m off the middle")
        self.actions += 1

    def step(self) -> None:
        """Drive for STEP seconds."""
        before, self._waited = self._braking, self._waited + 1
        self._braking = self._waited > TIMEOUT_STEPS and not self.manual
        now = self.in_force()
        self.car.step(now.throttle, now.brake, now.steer)
        self.frame += 1
        if self._braking != before:
            self.log("trouble: no action for 0.5 s: braking" if self._braking else "an action again: driving on")
