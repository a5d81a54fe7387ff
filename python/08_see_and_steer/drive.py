"""Lesson 08, the drive: the car's side of the client in Python. In C# it is Drive.cs.

client.send(drive.message())        the pictures, with their number and what the car does
drive.apply(client.receive())       now the action's age is known
drive.step()                        0.02 s later
"""

import argparse
import sys
import time
import uuid
from collections.abc import Callable

from netmq_example.asking import at_least_one, client_options
from netmq_example.camera.client import Action
from netmq_example.camera.pictures import encode
from netmq_example.messages import Array, Message
from netmq_example.program import printable, whole
from netmq_example.worlds.road import CAMERAS, STEP_SECONDS, Car, DrawnCamera, Road

# Steps without an action, after which the car brakes: half a second.
TIMEOUT_STEPS = 25


def drive_options(endpoint: str) -> argparse.Namespace:
    """The client's options: how it drives, and what it sends."""
    parser = client_options("Drives a car by what Python sees.", endpoint, timeout=1, beacon=True)
    parser.add_argument("--count", type=whole, default=500, help="end after so many actions")
    parser.add_argument("--every", type=whole, default=50, help="print one action in so many; 0: none")
    parser.add_argument("--tries", type=at_least_one, default=5, help="pictures in a row that may stay without action")
    parser.add_argument("--cameras", choices=CAMERAS, default="center", metavar="NAMES", help=" or ".join(CAMERAS))
    parser.add_argument("--start", type=whole, default=0, help="the point of the road to begin at")
    parser.add_argument("--lockstep", action="store_true", help="the world waits for each action")
    parser.add_argument("--drive", action="store_true", help="arrow keys or W A S D take over, Enter gives back")
    parser.add_argument("--jpeg", action="store_true", help="send JPEG files instead of raw bytes")
    options = parser.parse_args()
    if options.drive and not sys.stdin.isatty():
        parser.error("--drive needs a keyboard: start it in a terminal")
    return options


class Drive:
    """The car, steered by Python or by a person. It brakes when no action comes."""

    def __init__(self, options: argparse.Namespace, log: Callable[[str], object]) -> None:
        self.options = options
        self.log = log
        self.road = Road()
        self.car = Car.on(self.road, options.start % len(self.road.points))
        self.camera = DrawnCamera(self.road)
        self.run = uuid.uuid4().hex[:8]
        # The number of steps so far, and so of a picture that is taken now.
        self.frame = 0
        self.actions = 0
        self.manual = False
        # The last text from Python.
        self.text = ""
        self._braking = False
        self._waited = 0
        self._action = Action(0, 0.0, 1.0, 0.0)

    def in_force(self) -> Action:
        """The brake does not unlearn the steering: the road does not end at once."""
        return Action(self._action.frame, 0.0, 1.0, self._action.steer) if self._braking else self._action

    def take_over(self, throttle: float, brake: float, steer: float) -> None:
        """A person drives. Python is still asked, but not followed: that is how a person's driving is recorded."""
        if not self.manual:
            self.log("a person drives")
        self.manual = True
        self._action = Action(self.frame, throttle, brake, steer)

    def give_back(self) -> None:
        """Python's next action counts again."""
        if self.manual:
            self.log("Python drives")
        self.manual = False

    def message(self) -> Message:
        """The pictures of this moment, with their number and what the car does. Raw ones have the lowest row first."""
        now = self.in_force()
        jpeg = self.options.jpeg
        values = {
            "frame": self.frame,
            "run": self.run,
            "manual": self.manual,
            "sim_time": self.frame * STEP_SECONDS,
            "wall_time": time.time(),
            "speed": self.car.speed,
            "throttle": now.throttle,
            "brake": now.brake,
            "steer": now.steer,
            "cameras": self.options.cameras,
            "encoding": "jpeg" if jpeg else "raw",
            "bottom_up": not jpeg,
        }
        message = Message("frame", self.frame, values)
        for right in CAMERAS[self.options.cameras]:
            picture = self.camera.draw(self.car, self.frame, right)
            if jpeg:
                file = encode(picture[::-1])
                message.arrays.append(Array("uint8", (len(file),), file))
            else:
                message.arrays.append(Array("uint8", picture.shape, picture))
        return message

    def apply(self, newest: Action | None) -> None:
        """Follow an action from the next step on; None if there was none for the last picture."""
        if newest is None:
            # In lock-step no time passes meanwhile: the brake is on at once.
            if self.options.lockstep:
                self._waited = TIMEOUT_STEPS
            return
        self._waited = 0
        if not self.manual:
            self._action = newest
        if self.options.every and self.actions % self.options.every == 0:
            off = self.road.nearest(self.car.x, self.car.y)[1]
            timing = f"frame {newest.frame}: age {self.frame - newest.frame}, {newest.milliseconds:.1f} ms"
            self.log(f"{timing}; steer {newest.steer:.2f}, speed {self.car.speed:.1f} m/s, {off:.1f} m off the middle")
        self.actions += 1
        text = newest.values.get("text")
        if isinstance(text, str) and text != self.text:
            self.log(f"Python says {printable(text)}")
            self.text = text

    def step(self) -> None:
        """Drive for STEP_SECONDS."""
        before = self._braking
        self._waited += 1
        self._braking = self._waited > TIMEOUT_STEPS and not self.manual
        now = self.in_force()
        self.car.step(now.throttle, now.brake, now.steer)
        self.frame += 1
        if self._braking != before:
            self.log("trouble: no action for 0.5 s: braking" if self._braking else "an action again: driving on")
